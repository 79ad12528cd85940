#pragma once
/// Residuals of a zero-velocity update: zero velocity, and no motion between two poses.      docs/math/imu.md
///
///   r = v                                                        3x1 [m/s],   J_r_v = I                         (11)
///   r = T_j [-] T_i = [Log(R_i^T R_j); R_i^T (p_j - p_i)]        6x1 [rad, m]                                   (12)
///   J_r_i = [ -Jr^-1(r_phi) R_j^T R_i  0 ;  [r_p]x  -I ],   J_r_j = blkdiag(Jr^-1(r_phi), R_i^T R_j)

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct ZeroVelocity {
  using Scalar = S;
  static constexpr int dim = 3;
  struct Linearized {
    bool valid;
    Vec<S, 3> r;
    Mat<S, 3, 3> J_r_v;
  };

  Linearized linearize(const Vec<S, 3>& v_world_body) const {
    return {all_finite(v_world_body), v_world_body, identity<S, 3>()};  // (11)
  }
};

template <std::floating_point S>
struct ZeroMotion {
  using Scalar = S;
  static constexpr int dim = 6;
  struct Linearized {
    bool valid;
    Vec<S, 6> r;
    Mat<S, 6, 6> J_r_i, J_r_j;
  };

  Linearized linearize(const SE3<S>& T_world_i, const SE3<S>& T_world_j) const {
    return linearize(T_world_i, T_world_j, T_world_i, T_world_j);
  }

  /// Residual at (i, j), Jacobians at the first estimates (i0, j0).
  Linearized linearize(const SE3<S>& T_world_i, const SE3<S>& T_world_j, const SE3<S>& T_world_i0,
                       const SE3<S>& T_world_j0) const {
    Linearized out;
    out.r = minus(T_world_j, T_world_i);  // (12)
    out.J_r_j = minus_jacobian(T_world_j0, T_world_i0);
    set_zero(out.J_r_i);
    const Mat<S, 3, 3> minus_Jr_inverse = -block<3, 3>(out.J_r_j, 0, 0), R_i_j = block<3, 3>(out.J_r_j, 3, 3);
    const Vec<S, 3> p_i_j = T_world_i0.rotation().inverse() * Vec<S, 3>(T_world_j0.p() - T_world_i0.p());
    set_block(out.J_r_i, 0, 0, product_transposed(minus_Jr_inverse, R_i_j));
    set_block(out.J_r_i, 3, 0, hat(p_i_j));
    for (int k = 3; k < 6; ++k) out.J_r_i(k, k) = S(-1);
    out.valid = all_finite(out.r) && all_finite(out.J_r_i);
    return out;
  }
};

static_assert(Residual<ZeroVelocity<float>> && Residual<ZeroMotion<double>>);

}  // namespace plumbline
