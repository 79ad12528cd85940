#pragma once
/// A frame is taken in and predicted: the calibration in force, the IMU samples since the previous frame, the view of
/// its image; then its state, and from it the motion during its readout.

#include "plumbline/core/time.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/shutter_motion.hpp"
#include "plumbline/feature/view.hpp"

namespace plumbline {

/// The view of a frame whose image has been taken in. `is_first`: there is no frame before it.
template <class Parts, class MapT, class Sensors>
View<Sensors> take_in(const Components<Parts, MapT>& on, const Sensors& rig, const typename Sensors::Frame& frame,
                      bool is_first) {
  using S = typename Parts::S;
  const S dt = S(seconds_between(on.navigation.t_ns(), frame.t_ns));
  const typename Parts::Propagation::State latest = on.window.frames().latest();
  on.propagation.calibrate(on.rig_state, on.window.frames());
  on.propagation.begin_frame(frame.t_ns, is_first ? nullptr : &latest, dt);
  View<Sensors> view = on.tracker.images().view(rig, frame, on.propagation.T_body_cam(on.rig_state.T_body_cam()),
                                                on.rig_state.readout(), dt);
  set_shutter_motion(view, on.propagation, latest, on.window.mean_depth());
  return view;
}

/// The prediction of the frame.
template <class Parts, class MapT, class Sensors>
typename Components<Parts, MapT>::Window::Tracker::Predicted predict(const Components<Parts, MapT>& on,
                                                                     View<Sensors>& view) {
  using S = typename Parts::S;
  const auto align_motion = [&](const SE3<S>& guess) {
    return on.tracker.images().align_motion(view, guess, on.window.mean_depth(), on.tracker.is_after_gap(view.t_ns));
  };
  const auto predicted =
      on.propagation.predict(on.window.frames().latest(), view, S(on.tracker.outage_s(view.t_ns)), align_motion);
  set_shutter_motion(view, on.propagation, predicted.state, on.window.mean_depth());
  return predicted;
}

}  // namespace plumbline
