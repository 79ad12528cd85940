#pragma once
/// What the IMU says about the motion between two times, whatever the state it starts from: preintegration on the
/// manifold by the midpoint rule, with covariance and bias Jacobians.                           docs/math/imu.md
///
/// Over an interval, with w, a_0, a_1 = mean gyro, begin and end accel, less the biases of linearization:
///   dR+ = dR E,  E = Exp(w dt);    a = (dR a_0 + dR+ a_1)/2;   dp+ = dp + dv dt + a dt^2/2,  dv+ = dv + a dt     (3)
///   error [dphi dp dv dbg dba]+ = F [..] + B [n_g n_a]: noise enters like a bias of one interval            (4)
///   S+ = F S F^T + B diag(s_g^2/dt, s_a^2/dt) B^T + diag(walk^2 dt),   J+ = F J                                (5)
///   R_j = R_i dR,   v_j = v_i + g Dt + R_i dv,   p_j = p_i + v_i Dt + g Dt^2/2 + R_i dp                         (6)
///   dR^ = dR Exp(J_R_g dbg),   dv^ = dv + J_v_g dbg + J_v_a dba,   dp^ = dp + J_p_g dbg + J_p_a dba             (7)
/// dR, dv, dp hold no gravity: they are relative to the free fall that starts with the state at i.

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
  struct Delta {
    SO3<S> dR;
    Vec<S, 3> dp, dv;
  };

  S duration = S(0);  ///< Dt [s]
  Delta delta{SO3<S>(), Vec<S, 3>::Zero(), Vec<S, 3>::Zero()};
  Vec<S, 3> bias_gyro = Vec<S, 3>::Zero(), bias_accel = Vec<S, 3>::Zero();  ///< point of linearization
  Mat<S, 15, 15> covariance = Mat<S, 15, 15>::Zero();                       ///< S, of [dphi dp dv dbg dba]
  Mat<S, 9, 6> J_delta_bias = Mat<S, 9, 6>::Zero();                         ///< of [dphi dp dv] by [bg ba]

  Mat<S, 3, 3> J_R_g() const { return J_delta_bias.template block<3, 3>(0, 0); }
  Mat<S, 3, 3> J_p_g() const { return J_delta_bias.template block<3, 3>(3, 0); }
  Mat<S, 3, 3> J_p_a() const { return J_delta_bias.template block<3, 3>(3, 3); }
  Mat<S, 3, 3> J_v_g() const { return J_delta_bias.template block<3, 3>(6, 0); }
  Mat<S, 3, 3> J_v_a() const { return J_delta_bias.template block<3, 3>(6, 3); }

  ImuIncrement() = default;
  ImuIncrement(const Vec<S, 3>& bias_gyro_, const Vec<S, 3>& bias_accel_)
      : bias_gyro(bias_gyro_), bias_accel(bias_accel_) {}

  /// Longer by one interval, dt > 0.
  void integrate(const ImuInterval<S>& interval, const ImuNoise& noise);

  /// (7), first order in the gyroscope bias, exact in the accelerometer bias.
  Delta corrected(const Vec<S, 3>& gyro, const Vec<S, 3>& accel) const {
    Vec<S, 6> d;
    d << gyro - bias_gyro, accel - bias_accel;
    const Vec<S, 9> shift = J_delta_bias * d;
    return {delta.dR * SO3<S>::exp(shift.template head<3>()), delta.dp + shift.template segment<3>(3),
            delta.dv + shift.template tail<3>()};
  }

  /// (6), biases unchanged. Gravity is the acceleration of free fall in the world [m/s^2].
  NavState<S> predict(const NavState<S>& x, const Vec<S, 3>& gravity) const {
    const Delta d = corrected(x.bias_gyro, x.bias_accel);
    const SO3<S>& R = x.T_world_body.rotation();
    NavState<S> out = x;
    out.T_world_body = SE3<S>(
        R * d.dR, x.T_world_body.p() + duration * x.v_world_body + (S(0.5) * duration * duration) * gravity + R * d.dp);
    out.v_world_body += duration * gravity + R * d.dv;
    return out;
  }

  /// L, lower triangular, L^T L = S^-1. A floor of 1e-6 (rad, m, m/s) and 1e-7 (biases) keeps S regular.
  Result<Mat<S, 15, 15>> square_root_information() const {
    Mat<S, 15, 15> floored = covariance;
    floored.diagonal().template head<9>().array() += S(1e-12);
    floored.diagonal().template tail<6>().array() += S(1e-14);
    return plumbline::square_root_information(floored);
  }
};

template <std::floating_point S>
void ImuIncrement<S>::integrate(const ImuInterval<S>& interval, const ImuNoise& noise) {
  using Mat3 = Mat<S, 3, 3>;
  const S dt = interval.dt;
  const Vec<S, 3> phi = dt * (interval.mean_gyro() - bias_gyro);
  const Vec<S, 3> a0 = interval.accel_begin - bias_accel, a1 = interval.accel_end - bias_accel;
  const SO3<S> E = SO3<S>::exp(phi), dR1 = delta.dR * E;
  const Mat3 R0 = delta.dR.matrix(), R1 = dR1.matrix(), Et = E.matrix().transpose(), R1_a1 = R1 * hat(a1);

  Mat<S, 9, 15> F = Mat<S, 9, 15>::Zero();  // rows dphi, dp, dv of (4); those of the biases are the identity
  F.template block<3, 3>(0, 0) = Et;
  F.template block<3, 3>(0, 9) = -dt * SO3<S>::right_jacobian(phi);
  F.template block<3, 3>(6, 0) = (S(-0.5) * dt) * (R0 * hat(a0) + R1_a1 * Et);
  F.template block<3, 3>(6, 9) = (S(-0.5) * dt) * (R1_a1 * F.template block<3, 3>(0, 9));
  F.template block<3, 3>(6, 12) = (S(-0.5) * dt) * (R0 + R1);
  F.template middleRows<3>(3) = (S(0.5) * dt) * F.template bottomRows<3>();  // position is half a step of velocity
  F.template block<6, 6>(3, 3).diagonal().setOnes();
  F.template block<3, 3>(3, 6).diagonal().setConstant(dt);
  const Mat<S, 9, 6> B = F.template rightCols<6>();

  const Vec<S, 3> a = S(0.5) * (R0 * a0 + R1 * a1);  // (3)
  delta.dp += dt * delta.dv + (S(0.5) * dt * dt) * a;
  delta.dv += dt * a;
  delta.dR = dR1;
  duration += dt;

  const auto squared = [](S x) { return x * x; };
  Vec<S, 6> white, walk;
  white << Vec<S, 3>::Constant(squared(S(noise.gyro_density)) / dt + squared(interval.gyro_sigma)),
      Vec<S, 3>::Constant(squared(S(noise.accel_density)) / dt + squared(interval.accel_sigma));
  walk << Vec<S, 3>::Constant(squared(S(noise.gyro_walk)) * dt), Vec<S, 3>::Constant(squared(S(noise.accel_walk)) * dt);
  const Mat<S, 9, 15> FS = F.lazyProduct(covariance);  // (5); lazy: Eigen's large products are not free of a heap
  const Mat<S, 9, 9> S9 = FS.lazyProduct(F.transpose()) + (B * white.asDiagonal()).lazyProduct(B.transpose());
  covariance.template topLeftCorner<9, 9>() = S(0.5) * (S9 + S9.transpose());
  covariance.template topRightCorner<9, 6>() = FS.template rightCols<6>();
  covariance.template bottomLeftCorner<6, 9>() = FS.template rightCols<6>().transpose();
  covariance.diagonal().template tail<6>() += walk;
  const Mat<S, 9, 6> FJ = F.template leftCols<9>().lazyProduct(J_delta_bias);
  J_delta_bias = FJ + B;
}

}  // namespace plumbline
