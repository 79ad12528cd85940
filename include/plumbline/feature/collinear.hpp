#pragma once
/// Feature kind: lines through points, at most N landmarks. A kind of points must precede it in the list:
///
///   Features<Points<180>, Collinear<60>>
///
/// Detector finds segments in keyframes. Options: `options.collinear`.

#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/tracking/line_detector.hpp"

namespace plumbline {

template <int N, LineDetector DetectorT = LineSegmentDetector<>, template <class> class Loss = Huber>
struct Collinear {
  static constexpr int capacity = N;
  using Detector = DetectorT;

  template <SensorRig Sensors>
  using Kind = CollinearKind<Sensors, Loss>;

  template <class Options>
  struct Named {
    Options collinear;
  };
  static auto& options_of(auto& all) { return all.collinear; }
};

}  // namespace plumbline
