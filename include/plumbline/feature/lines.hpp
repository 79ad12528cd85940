#pragma once
/// Feature kind: straight edges, at most N landmarks, with a robust loss. Detector finds new ones, e.g.
/// opencv::LsdDetector<>. Options: `options.lines`.

#include "plumbline/feature/line_kind.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/tracking/line_detector.hpp"

namespace plumbline {

template <int N, LineDetector DetectorT = LineSegmentDetector<>, template <class> class Loss = Huber>
struct Lines {
  static_assert(N >= 8, "plumbline: fewer than eight lines carry no estimate");
  static constexpr int capacity = N;
  using Detector = DetectorT;

  template <SensorRig Sensors>
  using Kind = LineKind<Sensors, Loss>;

  template <class Options>
  struct Named {
    Options lines;
  };
  static auto& options_of(auto& all) { return all.lines; }
};

}  // namespace plumbline
