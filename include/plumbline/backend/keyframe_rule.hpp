#pragma once
/// When a frame is a keyframe, and which one goes when there is no more room.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_state.hpp"

namespace plumbline {

struct KeyframeOptions {
  double min_tracked_ratio = 0.5;  ///< of the landmarks in sight after the last keyframe
  double max_motion_rad = 0.15;    ///< mean motion of the landmarks in the image since the last keyframe
};

/// A camera without depth locates its landmarks by keyframes, and velocities and biases want them close; depth alone
/// drifts with every keyframe.
template <SensorRig Sensors>
constexpr KeyframeOptions default_keyframes() {
  if (!Sensors::has_depth) return {0.7, 0.0656};
  return {0.5, Sensors::has_imu ? 0.0933 : 0.15};
}

/// By parallax and overlap.
class KeyframeRule {
 public:
  explicit KeyframeRule(const KeyframeOptions& options) : options_(options) {}

  /// `tracked` of the landmarks, after the last keyframe there were `tracked_then`; they moved by motion_rad since.
  bool is_keyframe(int tracked, int tracked_then, double motion_rad) const {
    return tracked < options_.min_tracked_ratio * tracked_then || motion_rad > options_.max_motion_rad;
  }

  /// The slot of the keyframe that goes. Where one frame is known by the one before it they go in order of time, so
  /// that the chain stays whole; others by what the rest replaces best: far from the newest, near to the others,
  /// distances in units of the scene's depth and of the field of view, and never one of the two newest.
  template <class Window>
  static int leaving(const Window& window, typename Window::Scalar mean_depth, bool in_order) {
    return in_order ? window.oldest() : most_redundant(window, mean_depth);
  }

 private:
  template <class Window>
  static int most_redundant(const Window& window, typename Window::Scalar mean_depth) {
    using S = typename Window::Scalar;
    const auto distance = [&](int a, int b) {
      const Vec<S, 6> d = minus(window.T_world_body(a), window.T_world_body(b));
      return norm(segment<3>(d, 0)) + norm(segment<3>(d, 3)) / mean_depth;
    };
    const int newest = window.newest(), second = window.before(window[newest].sequence);
    int worst = -1;
    S worst_score = S(-1);
    for (int k = 0; k < Window::slots; ++k) {
      if (!window[k].used || k == newest || k == second) continue;
      S crowd = S(0);
      for (int j = 0; j < Window::slots; ++j) {
        if (window[j].used && j != k) crowd += S(1) / (S(0.02) + distance(k, j));
      }
      const S score = std::sqrt(distance(k, newest)) * crowd;
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
