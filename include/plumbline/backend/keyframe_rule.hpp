#pragma once
/// Keyframe decision by parallax and overlap, and the choice of the keyframe that leaves a full window.
///                                                                                          docs/math/window.md

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_state.hpp"

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

/// The decisions, from counts and poses.
class KeyframeRule {
 public:
  explicit KeyframeRule(const KeyframeOptions& options) : options_(options) {}

  /// `tracked`: landmarks tracked now, `tracked_then`: after the last keyframe, `motion_rad`: their mean motion since.
  bool is_keyframe(int tracked, int tracked_then, double motion_rad) const {
    return tracked < options_.min_tracked_ratio * tracked_then || motion_rad > options_.max_motion_rad;
  }

  /// Slot of the keyframe that leaves. With factors between successive frames (`in_order`) the oldest one. Otherwise
  /// the most redundant one: far from the newest, close to the others, never one of the two newest.
  ///                                                                                            docs/math/window.md (2)
  template <class Window>
  static int leaving(const Window& window, typename Window::Scalar mean_depth, bool in_order) {
    return in_order ? window.oldest() : most_redundant(window, mean_depth);
  }

 private:
  /// Maximum of score (2); positions are divided by `mean_depth`.
  template <class Window>
  static int most_redundant(const Window& window, typename Window::Scalar mean_depth) {
    using S = typename Window::Scalar;
    constexpr S distance_floor = S(0.02);  // tuned: docs/decisions/134 (chosen)
    const auto distance = [&](int a, int b) {
      const Vec<S, 6> d = minus(window.T_world_body(a), window.T_world_body(b));
      return norm(segment<3>(d, 0)) + norm(segment<3>(d, 3)) / mean_depth;
    };
    const int newest = window.newest(), second = window.before(window[newest].sequence);
    int worst = -1;
    S worst_score = S(-1);
    for (int k = 0; k < Window::slots; ++k) {
      if (!window[k].used || k == newest || k == second) continue;
      S density = S(0);
      for (int j = 0; j < Window::slots; ++j) {
        if (window[j].used && j != k) density += S(1) / (distance_floor + distance(k, j));
      }
      const S score = std::sqrt(distance(k, newest)) * density;
      if (score > worst_score) {
        worst_score = score;
        worst = k;
      }
    }
    return worst;
  }

  KeyframeOptions options_;
};

}  // namespace plumbline
