#pragma once
/// Keyframe decision by parallax and overlap.                                                 docs/math/window.md

#include "plumbline/sensor/rig.hpp"

namespace plumbline {

struct KeyframeOptions {
  /// A keyframe is added below this fraction of the landmarks tracked at the last keyframe;
  /// tuned: docs/decisions/134 (chosen).
  double min_tracked_ratio = 0.5;
  /// Mean motion of the landmarks in the image since the last keyframe beyond which one is added [rad];
  /// tuned: docs/decisions/134 (chosen).
  double max_motion_rad = 0.15;
};

/// Default options of a rig. Without depth landmarks are triangulated between keyframes, so these are frequent; with an
/// IMU they are closer because velocities and biases are estimated at them. With depth alone every keyframe adds drift.
/// tuned: docs/decisions/134 (chosen).
template <SensorRig Sensors>
constexpr KeyframeOptions default_keyframes() {
  if (!Sensors::has_depth) return {0.7, 0.0656};
  return {0.5, Sensors::has_imu ? 0.0933 : 0.15};
}

/// The decision, from counts.
class KeyframeRule {
 public:
  explicit KeyframeRule(const KeyframeOptions& options) : options_(options) {}

  /// `tracked`: landmarks tracked now, `tracked_then`: after the last keyframe, `motion_rad`: their mean motion since.
  bool is_keyframe(int tracked, int tracked_then, double motion_rad) const {
    return tracked < options_.min_tracked_ratio * tracked_then || motion_rad > options_.max_motion_rad;
  }

 private:
  KeyframeOptions options_;
};

}  // namespace plumbline
