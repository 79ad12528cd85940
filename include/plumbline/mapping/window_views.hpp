#pragma once
/// How every camera of the window sees every other one, computed once for all landmarks.    docs/math/window.md
///
/// Poses enter what is seen through T_target^-1 T_anchor alone: a step of the anchor moves it as a step of the target
/// would,
///   J_anchor = J_target transport,   transport = -Ad(T_target^-1 T_anchor).                                    (4)
/// This is taken at the linearization points, all else at the current state: (4) alone decides that a step of the whole
/// window, as the prior knows it, changes no residual (first-estimate Jacobians).

#include <array>

#include "plumbline/lie/se3.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/residual/relative_view.hpp"

namespace plumbline {

template <class S, int Slots>
class WindowViews {
 public:
  /// At the current poses, transports at the linearization points.
  void linearize(const FrameWindow<S, Slots>& window, const SE3<S>& T_body_cam) {
    update(window, T_body_cam);
    for_each_pair(window, [&](int anchor, int target) {
      const SE3<S> T_target_world = window[target].pose.linearization_point().inverse();
      at(transports_, anchor, target) = -(T_target_world * window[anchor].pose.linearization_point()).adjoint();
    });
  }
  /// The current poses alone, for values without Jacobians.
  void update(const FrameWindow<S, Slots>& window, const SE3<S>& T_body_cam) {
    for_each_pair(window, [&](int anchor, int target) {
      at(current_, anchor, target) =
          RelativeView<S>(window[anchor].pose.value(), window[target].pose.value(), T_body_cam);
    });
  }

  const RelativeView<S>& current(int anchor, int target) const { return at(current_, anchor, target); }
  /// (4), 6x6.
  const Mat<S, 6, 6>& transport(int anchor, int target) const { return at(transports_, anchor, target); }

 private:
  template <class T>
  using Table = std::array<T, Slots * Slots>;

  template <class T>
  static auto& at(T& table, int anchor, int target) {
    return table[static_cast<std::size_t>(anchor * Slots + target)];
  }

  static void for_each_pair(const FrameWindow<S, Slots>& window, auto&& visit) {
    for (int anchor = 0; anchor < Slots; ++anchor) {
      if (!window[anchor].used) continue;
      for (int target = 0; target < Slots; ++target) {
        if (window[target].used && target != anchor) visit(anchor, target);
      }
    }
  }

  Table<RelativeView<S>> current_;
  Table<Mat<S, 6, 6>> transports_;
};

}  // namespace plumbline
