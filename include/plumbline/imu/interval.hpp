#pragma once
/// Interval of IMU measurements between two times, linear in between: the unit of integration.  docs/math/imu.md
///
/// Two successive intervals with the means w_1, a_1 and w_2, a_2 are merged into one that keeps rotation and velocity
/// to second order in the angle, with th_k = dt_k w_k and u_k = dt_k/(dt_1 + dt_2):
///   w = u_1 w_1 + u_2 w_2 + u_1 dt_2 (w_1 x w_2)/2                                            (coning)
///   a = u_1 a_1 + u_2 a_2 + u_1 th_1 x a_1/2 + u_2 (th_1 + th_2/2) x a_2 - (th_1 + th_2) x a_end/2     (sculling)
///   begin, end = mean -+ (mean_2 - mean_1)                                                                    (2)

#include <Eigen/Geometry>
#include <cmath>
#include <concepts>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S>
struct ImuInterval {
  S dt = S(0);                       ///< [s]
  Vec<S, 3> gyro_begin, gyro_end;    ///< [rad/s]
  Vec<S, 3> accel_begin, accel_end;  ///< [m/s^2]
  S gyro_sigma = S(0);               ///< sigma of the mean besides sensor noise: gap, saturation [rad/s]
  /// Sigma of the mean besides sensor noise, per axis: gap, saturation, vibration [m/s^2].
  Vec<S, 3> accel_sigma = zeros<S, 3>();

  Vec<S, 3> mean_gyro() const { return S(0.5) * (gyro_begin + gyro_end); }
  Vec<S, 3> mean_accel() const { return S(0.5) * (accel_begin + accel_end); }

  /// Adds white noise to the accelerometer; `sigma`: of its mean over one second [m/s^2].
  void inflate_accelerometer_noise(S sigma) {
    for (int k = 0; k < 3; ++k) accel_sigma[k] = elementary::hypot(accel_sigma[k], sigma / std::sqrt(dt));
  }

  template <std::floating_point Other>
  ImuInterval<Other> cast() const {
    return {Other(dt),
            cast_to<Other>(gyro_begin),
            cast_to<Other>(gyro_end),
            cast_to<Other>(accel_begin),
            cast_to<Other>(accel_end),
            Other(gyro_sigma),
            cast_to<Other>(accel_sigma)};
  }
};

/// Merges two successive intervals, (2).
template <class S>
ImuInterval<S> merged(const ImuInterval<S>& a, const ImuInterval<S>& b) {
  ImuInterval<S> out;
  out.dt = a.dt + b.dt;
  const S ua = a.dt / out.dt, ub = b.dt / out.dt;
  const Vec<S, 3> w1 = a.mean_gyro(), w2 = b.mean_gyro(), w_half = w2 - w1, th1 = a.dt * w1, th2 = b.dt * w2;
  const Vec<S, 3> a1 = a.mean_accel(), a2 = b.mean_accel(), a_half = a2 - a1, a_mean = ua * a1 + ub * a2;
  const Vec<S, 3> w = ua * w1 + ub * w2 + (S(0.5) * ua) * w1.cross(th2);
  const Vec<S, 3> sculling =
      (S(0.5) * ua) * th1.cross(a1) + ub * (th1 + S(0.5) * th2).cross(a2) - S(0.5) * (th1 + th2).cross(a_mean + a_half);
  out.gyro_begin = w - w_half;
  out.gyro_end = w + w_half;
  out.accel_begin = a_mean + sculling - a_half;
  out.accel_end = a_mean + sculling + a_half;
  out.gyro_sigma = elementary::hypot(ua * a.gyro_sigma, ub * b.gyro_sigma);
  for (int k = 0; k < 3; ++k) out.accel_sigma[k] = elementary::hypot(ua * a.accel_sigma[k], ub * b.accel_sigma[k]);
  return out;
}

}  // namespace plumbline
