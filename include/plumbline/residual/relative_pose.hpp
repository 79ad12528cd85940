#pragma once
/// Measured pose of frame j in frame i, against the poses of both.                       docs/math/pose_graph.md
///
///   r     = minus(T_ij, T~) = [Log(R~^T R_ij); R~^T (p_ij - p~)],  T_ij = T_i^-1 T_j    6x1 [rad, m]         (1)
///   J_r_i = [-Jr^-1(r_phi) R_ij^T, 0;  R~^T [p_ij]x, -R~^T]                             6x6                  (2)
///   J_r_j = [Jr^-1(r_phi), 0;  0, R~^T R_ij]                                            6x6                  (3)
/// by the right increments [dphi, dp] of T_i and T_j. r is a right increment of the measurement T~: its covariance is
/// that of [dphi, dp] in frame j. The translation of (1) is turned into frame j, unlike R_i^T (p_j - p_i) - p~.
///
///   T_ik = T_ij T_jk:   d_ik = Ad(T_jk^-1) d_ij + d_jk                                                       (4)

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct RelativePoseResidual {
  using Scalar = S;
  using Pose = SE3<S>;
  static constexpr int dim = 6;
  struct Linearized {
    bool valid;
    Vec<S, 6> r;
    Mat<S, 6, 6> J_r_i, J_r_j;
  };

  Pose measured;  ///< T~ of T_i_j

  Vec<S, 6> residual(const Pose& T_world_i, const Pose& T_world_j) const {
    return minus(T_world_i.inverse() * T_world_j, measured);
  }

  Linearized linearize(const Pose& T_world_i, const Pose& T_world_j) const {
    const Pose T_i_j = T_world_i.inverse() * T_world_j;
    const Mat<S, 3, 3> R_ji = T_i_j.rotation().inverse().matrix(), Rt = measured.rotation().inverse().matrix();
    Linearized out;
    out.r = minus(T_i_j, measured);               // (1)
    out.J_r_j = minus_jacobian(T_i_j, measured);  // (3)
    set_zero(out.J_r_i);                          // (2)
    set_block(out.J_r_i, 0, 0, Mat<S, 3, 3>(-product(block<3, 3>(out.J_r_j, 0, 0), R_ji)));
    set_block(out.J_r_i, 3, 0, product_hat(Rt, T_i_j.p()));
    set_block(out.J_r_i, 3, 3, Mat<S, 3, 3>(-Rt));
    out.valid = all_finite(out.r) && all_finite(out.J_r_i);
    return out;
  }

  static Pose moved(const Pose& T, const Vec<S, 6>& d) { return plus(T, d); }
  /// The matrix of (4), which takes a right increment of T_i_j to one of T_i_k; i is any frame.
  static Mat<S, 6, 6> transport(const Pose& T_i_j, const Pose& T_i_k) { return (T_i_k.inverse() * T_i_j).adjoint(); }
};

static_assert(Residual<RelativePoseResidual<float>> && Residual<RelativePoseResidual<double>>);

}  // namespace plumbline
