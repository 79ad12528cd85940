#pragma once
// Random inertial states and exact IMU samples of a smooth random motion.

#include <cmath>

#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::test {

/// Attitude anywhere, biases of 0.05 rad/s and 0.3 m/s^2.
inline NavState<double> random_state(testing::Gaussian& normal) {
  NavState<double> x;
  x.T_world_body = SE3<double>(SO3<double>::exp(normal.vector<3>()), 2 * normal.vector<3>());
  x.v_world_body = normal.vector<3>();
  x.bias_gyro = 0.05 * normal.vector<3>();
  x.bias_accel = 0.3 * normal.vector<3>();
  return x;
}

/// IMU samples as smooth functions of time: about 1 rad/s and 4 m/s^2 besides gravity.
class RandomMotion {
 public:
  explicit RandomMotion(testing::Gaussian& normal) {
    for (Mat<double, 3, 4>* amplitudes : {&gyro_, &accel_})
      for (int i = 0; i < 4; ++i) amplitudes->col(i) = normal.vector<3>();
    phase_ = 3 * normal.vector<4>();
  }

  ImuSample at(TimeNs t_ns) const {
    const double t = static_cast<double>(t_ns) * 1e-9;
    Vec<double, 4> waves;
    for (int i = 0; i < 4; ++i) waves[i] = std::sin((2 + 5 * i) * t + phase_[i]);
    return {t_ns, 0.7 * gyro_ * waves, Vec<double, 3>(0, 0, 9.81) + 2.5 * accel_ * waves};
  }

 private:
  Mat<double, 3, 4> gyro_, accel_;
  Vec<double, 4> phase_;
};

inline ImuInterval<double> interval_between(const ImuSample& a, const ImuSample& b) {
  return {seconds_between(a.t_ns, b.t_ns), a.gyro, b.gyro, a.accel, b.accel};
}

/// Visits the intervals of that motion from one time to another, all of the same length.
template <class Visit>
void for_each_interval(const RandomMotion& motion, TimeNs begin_ns, TimeNs end_ns, int count, Visit&& visit) {
  const TimeNs step = (end_ns - begin_ns) / count;
  for (int k = 0; k < count; ++k)
    visit(interval_between(motion.at(begin_ns + k * step), motion.at(begin_ns + (k + 1) * step)));
}

}  // namespace plumbline::test
