#include "plumbline/propagation/stationarity_detector.hpp"

#include <cmath>

#include "catch.hpp"
#include "propagation/steady_samples.hpp"

using namespace plumbline;

TEST_CASE("stationarity_detector: IMU and images decide, with hysteresis") {
  const InertialOptions options;
  test::SteadySamples<double> samples;
  StationarityDetector<double> detector;
  samples.advance(0.5);
  CHECK_FALSE(detector.detect(samples.imu, samples.now, 0, options));  // too few samples
  samples.advance(1);
  CHECK_FALSE(detector.detect(samples.imu, samples.now, 1.1 * options.stationary_motion_px, options));
  CHECK(detector.was_imu_stationary());
  CHECK(detector.detect(samples.imu, samples.now, 0.9 * options.stationary_motion_px, options));
  CHECK(detector.detect(samples.imu, samples.now, 1.1 * options.stationary_motion_px, options));
  CHECK(detector.is_stationary());
  CHECK(std::abs(detector.state(9.81).bias_accel.norm()) < 1e-6);
  const double beyond = 1.1 * options.stationary_hysteresis * options.stationary_motion_px;
  CHECK_FALSE(detector.detect(samples.imu, samples.now, beyond, options));
}

TEST_CASE("stationarity_detector: without images a body at rest stays so until its IMU moves, and none comes to rest") {
  const InertialOptions options;
  test::SteadySamples<double> samples;
  StationarityDetector<double> detector;
  samples.advance(1.5);
  detector.keep(samples.imu, samples.now, options);
  CHECK_FALSE(detector.is_stationary());
  REQUIRE(detector.detect(samples.imu, samples.now, 0, options));
  samples.advance(0.5);
  detector.keep(samples.imu, samples.now, options);
  CHECK(detector.is_stationary());
  samples.rate = [](double t) { return Vec<double, 3>(0, 0, 0.5 * std::sin(6 * t)); };
  samples.advance(1);
  detector.keep(samples.imu, samples.now, options);
  CHECK_FALSE(detector.is_stationary());
}
