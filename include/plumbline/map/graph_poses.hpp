#pragma once
/// Poses and covariances of the window as those of a pose graph, by its residual.                  docs/math/map.md 1
///
/// Heading and position with an IMU, SE(3) with depth, else Sim(3): a pose in the window has no scale of its own, an
/// edge of the graph has the rotation alone that the residual leaves free.

#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/pose_graph.hpp"

namespace plumbline {

template <RelativeResidual Residual>
struct GraphPoses {
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Covariance = Mat<S, Residual::dim, Residual::dim>;
  static constexpr bool has_scale = std::is_same_v<Pose, Sim3<S>>;
  static constexpr bool has_gravity = Residual::dim == 4;

  static Pose from_sim3(const Sim3<S>& T) {
    if constexpr (has_scale) {
      return T;
    } else {
      return SE3<S>(T.rotation(), T.t());
    }
  }
  static Pose to_pose(const SE3<S>& T, S scale = S(1)) {
    if constexpr (has_scale) {
      return Pose(scale, T.rotation(), T.p());
    } else {
      return T;
    }
  }
  static Sim3<S> to_sim3(const auto& T) { return Sim3<S>(T); }
  /// A covariance of a pose T_i_j, right increment, as that of an edge.
  static Covariance of_increment(const Mat<S, 6, 6>& P, [[maybe_unused]] const Pose& T_map_j, S sigma_log_scale) {
    if constexpr (has_gravity) {
      const Mat<S, 4, 6> J = Residual::from_pose_increment(T_map_j);
      return product_transposed(product(J, P), J);
    } else if constexpr (has_scale) {
      Covariance out = zeros<Covariance>();
      set_block(out, 0, 0, P);
      out(6, 6) = sigma_log_scale * sigma_log_scale;
      return out;
    } else {
      return P;
    }
  }
};

}  // namespace plumbline
