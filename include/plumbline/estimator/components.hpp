#pragma once
/// References to the components of an estimator, for the steps that act on all of them: initialization, and the work on
/// a keyframe.

#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/estimator/keyframe_window.hpp"
#include "plumbline/state/rig_state.hpp"
#include "plumbline/state/tracking_state.hpp"

namespace plumbline {

template <class Parts, class MapT>
struct Components {
  using Window = KeyframeWindow<Parts, MapT>;

  typename Window::Tracker& tracker;
  Window& window;
  typename Parts::Propagation& propagation;
  RigState<typename Parts::Sensors>& rig_state;
  typename Window::Nav& navigation;
  FrameReport& report;
  TrackingStatus& status;
};

}  // namespace plumbline
