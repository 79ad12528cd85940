#pragma once
/// Inertial state of the body at one time, and its error.                                       docs/math/imu.md
///
///   x = (T_world_body, v, b_g, b_a),   error (15) = [dphi, dp, dv, dbg, dba]                                 (1)
/// One order for state, residual, covariance and information. Pose increments are those of lie/plus.hpp, the others are
/// additive.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <std::floating_point S>
struct NavState {
  static constexpr int dof = 15;
  /// Of the blocks in (1)
  enum Offset : int { rotation = 0, position = 3, velocity = 6, gyro_bias = 9, accel_bias = 12 };

  SE3<S> T_world_body;
  Vec<S, 3> v_world_body = zeros<S, 3>();  ///< [m/s]
  Vec<S, 3> bias_gyro = zeros<S, 3>();     ///< [rad/s]
  Vec<S, 3> bias_accel = zeros<S, 3>();    ///< [m/s^2]

  bool is_finite() const {
    return T_world_body.is_finite() && all_finite(v_world_body) && all_finite(bias_gyro) && all_finite(bias_accel);
  }

  template <std::floating_point Other>
  NavState<Other> cast() const {
    return {T_world_body.template cast<Other>(), cast_to<Other>(v_world_body), cast_to<Other>(bias_gyro),
            cast_to<Other>(bias_accel)};
  }
};

/// x [+] d.
template <class S>
NavState<S> plus(const NavState<S>& x, const Vec<S, 15>& d) {
  return {plus(x.T_world_body, segment<6>(d, 0)), x.v_world_body + segment<3>(d, 6), x.bias_gyro + segment<3>(d, 9),
          x.bias_accel + segment<3>(d, 12)};
}

/// x1 [-] x0: plus(x0, minus(x1, x0)) = x1.
template <class S>
Vec<S, 15> minus(const NavState<S>& x1, const NavState<S>& x0) {
  Vec<S, 15> d;
  set_segment(d, 0, minus(x1.T_world_body, x0.T_world_body));
  set_segment(d, 6, Vec<S, 3>(x1.v_world_body - x0.v_world_body));
  set_segment(d, 9, Vec<S, 3>(x1.bias_gyro - x0.bias_gyro));
  set_segment(d, 12, Vec<S, 3>(x1.bias_accel - x0.bias_accel));
  return d;
}

/// d minus(x, x0) / dx, 15x15.
template <class S>
Mat<S, 15, 15> minus_jacobian(const NavState<S>& x, const NavState<S>& x0) {
  Mat<S, 15, 15> J = identity<S, 15>();
  set_block(J, 0, 0, minus_jacobian(x.T_world_body, x0.T_world_body));
  return J;
}

}  // namespace plumbline
