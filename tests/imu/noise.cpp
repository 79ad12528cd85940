#include "plumbline/imu/noise.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/imu/increment.hpp"

using namespace plumbline;

namespace {

/// Covariance of two seconds at rest, of as many intervals.
Mat<double, 15, 15> covariance_at_rest(const ImuNoise& noise, int intervals) {
  ImuIncrement<double> increment;
  const Vec<double, 3> gyro(0, 0, 0), accel(0, 0, 0);
  for (int k = 0; k < intervals; ++k) increment.integrate({2.0 / intervals, gyro, gyro, accel, accel}, noise);
  return increment.covariance;
}

}  // namespace

TEST_CASE("noise: densities are of continuous time, whatever the rate of the samples") {
  const ImuNoise noise{.gyro_density = 1e-3, .accel_density = 2e-3, .gyro_walk = 3e-5, .accel_walk = 4e-4};
  for (const int intervals : {100, 400}) {
    CAPTURE(intervals);
    const Mat<double, 15, 15> P = covariance_at_rest(noise, intervals);
    for (int k = 0; k < 3; ++k) {
      CHECK(std::sqrt(P(k, k)) == Approx(1e-3 * std::sqrt(2.0)).epsilon(0.01));          // of a rotation [rad]
      CHECK(std::sqrt(P(6 + k, 6 + k)) == Approx(2e-3 * std::sqrt(2.0)).epsilon(0.03));  // of a velocity [m/s]
      CHECK(std::sqrt(P(9 + k, 9 + k)) == Approx(3e-5 * std::sqrt(2.0)).epsilon(1e-9));
      CHECK(std::sqrt(P(12 + k, 12 + k)) == Approx(4e-4 * std::sqrt(2.0)).epsilon(1e-9));
    }
  }
}

TEST_CASE("noise: a density of zero adds nothing") {
  const ImuNoise none{.gyro_density = 0, .accel_density = 0, .gyro_walk = 0, .accel_walk = 0};
  CHECK(covariance_at_rest(none, 10).isZero(0));
  CHECK(covariance_at_rest({}, 10).trace() > 0);  // an IMU without a calibration has noise
}
