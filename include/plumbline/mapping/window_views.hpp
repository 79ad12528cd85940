#pragma once
/// How every camera of the window sees every other one, computed once for all landmarks.    docs/math/window.md
///
/// Two sets: at the current poses, for residuals, and at the linearization points, for Jacobians. They differ only
/// where the prior has fixed a linearization point (first-estimate Jacobians).

#include <array>

#include "plumbline/lie/se3.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/residual/relative_view.hpp"

namespace plumbline {

template <class S, int Slots>
class WindowViews {
 public:
  /// At the current poses and linearization points.
  void linearize(const FrameWindow<S, Slots>& window, const SE3<S>& T_body_cam) {
    update(window, T_body_cam);
    for_each_pair(window, [&](int anchor, int target) {
      at(linear_, anchor, target) = RelativeView<S>(window[anchor].pose.linearization_point(),
                                                    window[target].pose.linearization_point(), T_body_cam);
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
  const RelativeView<S>& linear(int anchor, int target) const { return at(linear_, anchor, target); }

 private:
  using Table = std::array<RelativeView<S>, Slots * Slots>;

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

  Table current_, linear_;
};

}  // namespace plumbline
