#pragma once
/// Residual of two inertial states against the preintegrated IMU increment between them, with the random walk of the
/// biases.
///                                                                                              docs/math/imu.md
///
///   r_phi = Log(dR^^T R_i^T R_j)                                       [rad]          15x1, order of nav_state.hpp (9)
///   r_p   = R_i^T (p_j - p_i - v_i Dt - g Dt^2/2) - dp^                [m]
///   r_v   = R_i^T (v_j - v_i - g Dt) - dv^                             [m/s]
///   r_bg  = bg_j - bg_i,   r_ba = ba_j - ba_i                          [rad/s, m/s^2]
/// dR^, dp^, dv^ are the increment corrected to the biases of state i, increment.hpp (7). Jacobians, Ji = Jr^-1(r_phi):
///   r_phi  by dphi_i: -Ji R_j^T R_i;  dphi_j: Ji;  dbg_i: -Ji Exp(r_phi)^T Jr(J_R_g dbg) J_R_g                    (10)
///   r_p    by dphi_i: [r_p + dp^]x;  dp_i: -I;  dv_i: -R_i^T Dt;  dbg_i: -J_p_g;  dba_i: -J_p_a;  dp_j: R_i^T R_j
///   r_v    by dphi_i: [r_v + dv^]x;  dv_i: -R_i^T;  dbg_i: -J_v_g;  dba_i: -J_v_a;  dv_j: R_i^T
///   r_bg, r_ba  by the biases of i: -I, of j: I

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct InertialResidual {
  using Scalar = S;
  static constexpr int dim = 15;
  struct Linearized {
    bool valid;
    Vec<S, 15> r;
    Mat<S, 15, 15> J_r_i, J_r_j;

    /// Multiplies by L of `ImuIncrement::square_root_information`.
    void whiten(const Mat<S, 15, 15>& L) {
      r = product(L, r);
      J_r_i = product(L, J_r_i);
      J_r_j = product(L, J_r_j);
    }
  };

  const ImuIncrement<S>& increment;  ///< the measurement, owned by the caller
  Vec<S, 3> gravity;                 ///< acceleration of free fall in the world [m/s^2]

  Linearized linearize(const NavState<S>& x_i, const NavState<S>& x_j) const { return linearize(x_i, x_j, x_i, x_j); }

  /// Residual at (x_i, x_j), Jacobians at the first estimates (x_i0, x_j0): they are derivatives by e in x = x0 [+] e.
  Linearized linearize(const NavState<S>& x_i, const NavState<S>& x_j, const NavState<S>& x_i0,
                       const NavState<S>& x_j0) const {
    Linearized out;
    out.r = residual(x_i, x_j);
    jacobians(x_i0, x_j0, out.J_r_i, out.J_r_j);
    out.valid = increment.duration > S(0) && all_finite(out.r) && all_finite(out.J_r_i);
    return out;
  }

  /// (9)
  Vec<S, 15> residual(const NavState<S>& x_i, const NavState<S>& x_j) const {
    const typename ImuIncrement<S>::Delta d = increment.corrected(x_i.bias_gyro, x_i.bias_accel);
    const SO3<S> R_body_world = x_i.T_world_body.rotation().inverse();
    Vec<S, 15> r;
    set_segment(r, 0, (d.dR.inverse() * R_body_world * x_j.T_world_body.rotation()).log());
    set_segment(r, 3, Vec<S, 3>(R_body_world * beyond_fall(x_i, x_j) - d.dp));
    set_segment(r, 6, Vec<S, 3>(R_body_world * velocity_change(x_i, x_j) - d.dv));
    set_segment(r, 9, Vec<S, 3>(x_j.bias_gyro - x_i.bias_gyro));
    set_segment(r, 12, Vec<S, 3>(x_j.bias_accel - x_i.bias_accel));
    return r;
  }

  /// (10)
  void jacobians(const NavState<S>& x_i, const NavState<S>& x_j, Mat<S, 15, 15>& J_r_i, Mat<S, 15, 15>& J_r_j) const {
    using Mat3 = Mat<S, 3, 3>;
    const Mat3 J_R_g = increment.J_R_g();
    const Vec<S, 3> bias_shift = J_R_g * Vec<S, 3>(x_i.bias_gyro - increment.bias_gyro);
    const SO3<S> R_i_j = x_i.T_world_body.rotation().inverse() * x_j.T_world_body.rotation();
    const SO3<S> error = (increment.delta.dR * SO3<S>::exp(bias_shift)).inverse() * R_i_j;
    const Mat3 R_i_transposed = x_i.T_world_body.R().transpose(), Ji = SO3<S>::right_jacobian_inverse(error.log());

    const Mat3 minus_Ji = -Ji, turned_back = minus_Ji * error.inverse().matrix();
    const Mat3 shifted = SO3<S>::right_jacobian(bias_shift) * J_R_g;

    set_zero(J_r_i);
    set_block(J_r_i, 0, 0, product(minus_Ji, R_i_j.inverse().matrix()));
    set_block(J_r_i, 0, 9, product(turned_back, shifted));
    set_block(J_r_i, 3, 0, hat(Vec<S, 3>(R_i_transposed * beyond_fall(x_i, x_j))));
    set_block(J_r_i, 3, 6, Mat3(-increment.duration * R_i_transposed));
    set_block(J_r_i, 6, 0, hat(Vec<S, 3>(R_i_transposed * velocity_change(x_i, x_j))));
    set_block(J_r_i, 6, 6, Mat3(-R_i_transposed));
    for (int c = 0; c < 6; ++c) {
      for (int r = 3; r < 9; ++r) J_r_i(r, 9 + c) = -increment.J_delta_bias(r, c);
    }
    for (const int k : {3, 4, 5, 9, 10, 11, 12, 13, 14}) J_r_i(k, k) = S(-1);

    set_identity(J_r_j);
    set_block(J_r_j, 0, 0, Ji);
    set_block(J_r_j, 3, 3, R_i_j.matrix());
    set_block(J_r_j, 6, 6, R_i_transposed);
  }

 private:
  /// Displacement beyond free fall, in the world [m].
  Vec<S, 3> beyond_fall(const NavState<S>& x_i, const NavState<S>& x_j) const {
    const S t = increment.duration;
    return x_j.T_world_body.p() - x_i.T_world_body.p() - t * x_i.v_world_body - (S(0.5) * t * t) * gravity;
  }
  /// Change of velocity beyond free fall, in the world [m/s].
  Vec<S, 3> velocity_change(const NavState<S>& x_i, const NavState<S>& x_j) const {
    return x_j.v_world_body - x_i.v_world_body - increment.duration * gravity;
  }
};

static_assert(Residual<InertialResidual<float>> && Residual<InertialResidual<double>>);

}  // namespace plumbline
