#pragma once
/// Relative poses between all cameras of a window, computed once for all landmarks.            docs/math/window.md
///
/// Visual residuals depend on poses through T_target^-1 T_anchor alone: a step of the anchor acts like one of the
/// target,
///   J_anchor = -J_target transport,   transport = Ad(T_target^-1 T_anchor).                                    (4)
/// The transport is taken at the linearization points, everything else at the current state: (4) alone makes a common
/// step of the whole window, as the prior contains it, leave all residuals unchanged (first-estimate Jacobians).

#include <array>

#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/state/frame_window.hpp"

namespace plumbline {

template <class S, int Slots>
class WindowViews {
 public:
  /// Computes all views at the current poses, with the estimated extrinsics or else `given`.
  void update(const auto& window, const SE3<S>& given) {
    const SE3<S>& T_body_cam = window.T_body_cam(given);
    for_each_pair(window, [&](int anchor, int target) {
      at(anchor, target) = RelativeView<S>(window.T_world_body(anchor), window.T_world_body(target), T_body_cam);
    });
  }

  /// Sets the transports (4) of `pairs`, a RelativeEquations.
  template <class Pairs>
  static void set_transports(const auto& window, Pairs& pairs) {
    for_each_pair(window, [&](int anchor, int target) {
      using T = typename Pairs::Scalar;
      const SE3<T> T_world_anchor = first_pose(window, anchor).template cast<T>();
      const SE3<T> T_world_target = first_pose(window, target).template cast<T>();
      pairs.set_transport(anchor, target, (T_world_target.inverse() * T_world_anchor).adjoint());
    });
  }

  const RelativeView<S>& operator()(int anchor, int target) const {
    return views_[static_cast<std::size_t>(anchor * Slots + target)];
  }

 private:
  RelativeView<S>& at(int anchor, int target) { return views_[static_cast<std::size_t>(anchor * Slots + target)]; }

  static const SE3<S>& first_pose(const auto& window, int slot) {
    return window[slot].state.template get<state::Pose>().first_estimate();
  }
  static void for_each_pair(const auto& window, auto&& visit) {
    for (int anchor = 0; anchor < Slots; ++anchor) {
      if (!window[anchor].used) continue;
      for (int target = 0; target < Slots; ++target) {
        if (window[target].used && target != anchor) visit(anchor, target);
      }
    }
  }

  std::array<RelativeView<S>, Slots * Slots> views_;
};

}  // namespace plumbline
