#pragma once
/// Measured pose of frame j in frame i, against heading and position of both: roll and pitch are known from gravity.
///                                                                                       docs/math/pose_graph.md
///   increment  T [+] [dpsi; dp] = (Rz(dpsi) R, p + R dp),  Rz about the vertical of the world                 (5)
///   r_psi = atan2(M_10 - M_01, M_00 + M_11),  M = R_j R~^T R_i^T                        [rad]                 (6)
///   r_p   = R~^T (p_ij - p~),  p_ij = R_i^T (p_j - p_i)                                 3x1 [m]
///   J_r_i = [-1, 0;  -R~^T R_i^T (e3 x (p_j - p_i)), -R~^T],  J_r_j = [1, 0;  0, R~^T R_ij]          4x4      (7)
/// (5) is the restriction of the library's increment to dphi = R^T e3 dpsi. (6) is the heading psi that maximizes
/// trace(Rz(psi)^T M): it has no gimbal lock, and is exactly linear in the headings. It is undefined, `valid` is false,
/// where M turns the vertical upside down.
///
///   d_ik = [1, 0;  R_k^T (e3 x (p_k - p_j)), R_k^T R_j] d_ij + d_jk                                           (8)

#include <cmath>
#include <concepts>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct RelativePoseYawResidual {
  using Scalar = S;
  using Pose = SE3<S>;
  static constexpr int dim = 4;
  struct Linearized {
    bool valid;
    Vec<S, 4> r;
    Mat<S, 4, 4> J_r_i, J_r_j;
  };

  Pose measured;  ///< T~ of T_i_j

  /// NaN where the heading is undefined.
  Vec<S, 4> residual(const Pose& T_world_i, const Pose& T_world_j) const {
    const Mat<S, 3, 3> M =
        (T_world_j.rotation() * measured.rotation().inverse() * T_world_i.rotation().inverse()).matrix();
    const S c = M(0, 0) + M(1, 1), s = M(1, 0) - M(0, 1);
    const Vec<S, 3> p_ij = T_world_i.rotation().inverse() * Vec<S, 3>(T_world_j.p() - T_world_i.p());
    Vec<S, 4> r;
    r[0] = c * c + s * s > S(1e-6) ? elementary::atan2(s, c) : S(NAN);  // (6)
    set_segment(r, 1, measured.rotation().inverse() * Vec<S, 3>(p_ij - measured.p()));
    return r;
  }

  Linearized linearize(const Pose& T_world_i, const Pose& T_world_j) const {
    const Vec<S, 3> p = T_world_j.p() - T_world_i.p(), across(-p.y(), p.x(), S(0));  // e3 x p
    const SO3<S> R_ji_measured = measured.rotation().inverse(), R_i_world = T_world_i.rotation().inverse();
    Linearized out;
    out.r = residual(T_world_i, T_world_j);
    set_zero(out.J_r_i);  // (7)
    set_zero(out.J_r_j);
    out.J_r_i(0, 0) = S(-1);
    out.J_r_j(0, 0) = S(1);
    set_block(out.J_r_i, 1, 0, Vec<S, 3>(-(R_ji_measured * (R_i_world * across))));
    set_block(out.J_r_i, 1, 1, Mat<S, 3, 3>(-R_ji_measured.matrix()));
    set_block(out.J_r_j, 1, 1, (R_ji_measured * R_i_world * T_world_j.rotation()).matrix());
    out.valid = all_finite(out.r) && all_finite(out.J_r_i) && all_finite(out.J_r_j);
    return out;
  }

  /// (5)
  static Pose moved(const Pose& T, const Vec<S, 4>& d) {
    return Pose(SO3<S>::exp({S(0), S(0), d[0]}) * T.rotation(), T.p() + T.rotation() * segment<3>(d, 1));
  }
  /// The matrix of (8). Both poses are in one frame whose z axis is vertical.
  static Mat<S, 4, 4> transport(const Pose& T_world_j, const Pose& T_world_k) {
    const SO3<S> R_k_world = T_world_k.rotation().inverse();
    const Vec<S, 3> p = T_world_k.p() - T_world_j.p();
    Mat<S, 4, 4> A = zeros<S, 4, 4>();
    A(0, 0) = S(1);
    set_block(A, 1, 0, R_k_world * Vec<S, 3>(-p.y(), p.x(), S(0)));
    set_block(A, 1, 1, (R_k_world * T_world_j.rotation()).matrix());
    return A;
  }
  /// [dpsi; dp] of a right increment [dphi; dp] of T_world_j: J P J^T is the covariance for a P of six rows.
  static Mat<S, 4, 6> from_pose_increment(const Pose& T_world_j) {
    const Mat<S, 3, 3> R = T_world_j.R();
    Mat<S, 4, 6> J = zeros<S, 4, 6>();
    for (int k = 0; k < 3; ++k) {
      J(0, k) = R(2, k);
      J(1 + k, 3 + k) = S(1);
    }
    return J;
  }
};

static_assert(Residual<RelativePoseYawResidual<float>> && Residual<RelativePoseYawResidual<double>>);

}  // namespace plumbline
