// A camera without depth and an IMU, points.                                               docs/math/inertial_window.md
#include "backend/consistency.hpp"

using namespace plumbline;

using Run = test::SimulatedRun<test::MonoImu, 10, Points<90>>;

TEST_CASE("sliding_window: mono-imu/points: errors are those that the covariance tells of") {
  test::require_consistent<Run>();
}

TEST_CASE("sliding_window: mono-imu/points: half the noise is half the error") {
  test::require_error_follows_noise<Run>();
}

TEST_CASE("sliding_window: mono-imu/points: position and heading of the whole stay unknown") {
  test::require_whole_unobservable<Run>();
}
