#pragma once
/// Preintegrated IMU increment: rotation, velocity and position change between two times, independent of the initial
/// state, on the manifold by the midpoint rule, with covariance and bias Jacobians.                    docs/math/imu.md
///
/// Over one interval, with w, a_0, a_1 = mean gyro, begin and end accel, minus the biases of linearization:
///   dR+ = dR E,  E = Exp(w dt);    a = (dR a_0 + dR+ a_1)/2;   dp+ = dp + dv dt + a dt^2/2,  dv+ = dv + a dt     (3)
///   error [dphi dp dv dbg dba]+ = F [..] + B [n_g n_a]: noise enters like a bias of one interval            (4)
///   S+ = F S F^T + B diag(s_g^2/dt, s_a^2/dt) B^T + diag(walk^2 dt),   J+ = F J                                (5)
///   R_j = R_i dR,   v_j = v_i + g Dt + R_i dv,   p_j = p_i + v_i Dt + g Dt^2/2 + R_i dp                         (6)
///   dR^ = dR Exp(J_R_g dbg),   dv^ = dv + J_v_g dbg + J_v_a dba,   dp^ = dp + J_p_g dbg + J_p_a dba             (7)
/// dR, dv, dp do not contain gravity: they are relative to free fall from the state at i.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
struct ImuIncrement {
  /// Rotation [rad], position [m] and velocity change [m/s].
  struct Delta {
    SO3<S> dR;
    Vec<S, 3> dp, dv;
  };

  S duration = S(0);  ///< Dt [s]
  Delta delta{SO3<S>(), zeros<S, 3>(), zeros<S, 3>()};
  Vec<S, 3> bias_gyro = zeros<S, 3>(), bias_accel = zeros<S, 3>();  ///< biases of linearization [rad/s, m/s^2]
  Mat<S, 15, 15> covariance = zeros<S, 15, 15>();                   ///< S of [dphi dp dv dbg dba]
  Mat<S, 9, 6> J_delta_bias = zeros<S, 9, 6>();                     ///< J: [dphi dp dv] by [bg ba]

  Mat<S, 3, 3> J_R_g() const { return block<3, 3>(J_delta_bias, 0, 0); }
  Mat<S, 3, 3> J_p_g() const { return block<3, 3>(J_delta_bias, 3, 0); }
  Mat<S, 3, 3> J_p_a() const { return block<3, 3>(J_delta_bias, 3, 3); }
  Mat<S, 3, 3> J_v_g() const { return block<3, 3>(J_delta_bias, 6, 0); }
  Mat<S, 3, 3> J_v_a() const { return block<3, 3>(J_delta_bias, 6, 3); }

  ImuIncrement() = default;
  ImuIncrement(const Vec<S, 3>& b_g, const Vec<S, 3>& b_a) : bias_gyro(b_g), bias_accel(b_a) {}

  /// Extends the increment by one interval, dt > 0.
  void integrate(const ImuInterval<S>& interval, const ImuNoise& noise);

  /// (7), first order in the gyroscope bias, exact in the accelerometer bias.
  Delta corrected(const Vec<S, 3>& gyro, const Vec<S, 3>& accel) const {
    const Vec<S, 3> dbg = gyro - bias_gyro, dba = accel - bias_accel;
    return {delta.dR * SO3<S>::exp(J_R_g() * dbg), delta.dp + J_p_g() * dbg + J_p_a() * dba,
            delta.dv + J_v_g() * dbg + J_v_a() * dba};
  }

  /// State after the increment, (6); biases unchanged. `gravity`: acceleration of free fall in the world [m/s^2].
  NavState<S> predict(const NavState<S>& x, const Vec<S, 3>& gravity) const {
    const Delta d = corrected(x.bias_gyro, x.bias_accel);
    const SO3<S>& R = x.T_world_body.rotation();
    NavState<S> out = x;
    out.T_world_body = SE3<S>(
        R * d.dR, x.T_world_body.p() + duration * x.v_world_body + (S(0.5) * duration * duration) * gravity + R * d.dp);
    out.v_world_body += duration * gravity + R * d.dv;
    return out;
  }

  /// Whether the first-order correction (7) to this gyroscope bias is inaccurate: a rotation of more than 0.01 rad, or
  /// a second-order error of the velocity above a tenth of its sigma. The accelerometer bias is corrected exactly.
  bool is_far(const Vec<S, 3>& gyro) const {
    const Vec<S, 3> d = gyro - bias_gyro;
    const S angle = norm(d) * duration, variance = covariance(6, 6);
    const S velocity = norm(J_v_g() * d) * angle;
    constexpr S max_angle = S(0.01), max_error2 = S(0.01);  // numerics: error of (7) below a tenth of its sigma
    return !(angle <= max_angle) || velocity * velocity > max_error2 * variance;
  }

  /// L, lower triangular, L^T L = S^-1. A floor of sigma 1e-6 (rad, m, m/s) and 1e-7 (biases) keeps S regular.
  Result<Mat<S, 15, 15>> square_root_information() const {
    constexpr S motion_floor = S(1e-12), bias_floor = S(1e-14);  // numerics: S stays regular
    Mat<S, 15, 15> floored = covariance;
    for (int k = 0; k < 15; ++k) floored(k, k) += k < 9 ? motion_floor : bias_floor;
    return plumbline::square_root_information(floored);
  }
};

template <std::floating_point S>
void ImuIncrement<S>::integrate(const ImuInterval<S>& interval, const ImuNoise& noise) {
  using Mat3 = Mat<S, 3, 3>;
  const S dt = interval.dt, half_dt = S(0.5) * dt;
  const Vec<S, 3> phi = dt * (interval.mean_gyro() - bias_gyro);
  const Vec<S, 3> a0 = interval.accel_begin - bias_accel, a1 = interval.accel_end - bias_accel;
  const SO3<S> E = SO3<S>::exp(phi), dR1 = delta.dR * E;
  const Mat3 R0 = delta.dR.matrix(), R1 = dR1.matrix(), Et = E.inverse().matrix(), R1_a1 = R1 * hat(a1);

  const Mat3 phi_g = -dt * SO3<S>::right_jacobian(phi), R1_a1_Et = R1_a1 * Et, v_phi = R0 * hat(a0) + R1_a1_Et;
  Mat<S, 9, 15> F;  // rows dphi, dp, dv of (4); those of the biases are the identity
  set_zero(F);
  set_block(F, 0, 0, Et);
  set_block(F, 0, 9, phi_g);
  set_block(F, 6, 0, Mat3(-half_dt * v_phi));
  set_block(F, 6, 9, Mat3(-half_dt * (R1_a1 * phi_g)));
  set_block(F, 6, 12, Mat3(-half_dt * (R0 + R1)));
  for (int c = 0; c < 15; ++c) {
    for (int r = 0; r < 3; ++r) F(3 + r, c) = half_dt * F(6 + r, c);  // dp+ = dp + dt dv + dt/2 (change of dv)
  }
  for (int k = 0; k < 3; ++k) {
    F(3 + k, 3 + k) = F(6 + k, 6 + k) = S(1);
    F(3 + k, 6 + k) = dt;
  }

  const Vec<S, 3> a = S(0.5) * (R0 * a0 + R1 * a1);  // (3)
  delta.dp += dt * delta.dv + half_dt * dt * a;
  delta.dv += dt * a;
  delta.dR = dR1;
  duration += dt;

  Mat<S, 9, 15> FS = product(F, covariance);  // (5)
  for (int k = 9; k < 15; ++k) {
    const bool of_gyro = k < 12;
    const S density = S(of_gyro ? noise.gyro_density : noise.accel_density);
    const S sigma = of_gyro ? interval.gyro_sigma : interval.accel_sigma[k - 12];
    const S walk = S(of_gyro ? noise.gyro_walk : noise.accel_walk);
    const S white = density * density / dt + sigma * sigma;
    covariance(k, k) += walk * walk * dt;
    for (int r = 0; r < 9; ++r) {
      covariance(r, k) = covariance(k, r) = FS(r, k);
      FS(r, k) += white * F(r, k);  // noise enters like a bias: B is part of F
    }
  }
  const Mat<S, 9, 9> S9 = product_transposed(FS, F);
  for (int c = 0; c < 9; ++c) {
    for (int r = 0; r <= c; ++r) covariance(r, c) = covariance(c, r) = S(0.5) * (S9(r, c) + S9(c, r));
  }
  const Mat<S, 9, 6> FJ = product(block<9, 9>(F, 0, 0), J_delta_bias);
  J_delta_bias = block<9, 6>(F, 0, 9);  // B
  J_delta_bias += FJ;
}

}  // namespace plumbline
