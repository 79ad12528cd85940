// An RGB-D camera and an IMU, points.                                                      docs/math/inertial_window.md
#include "backend/consistency.hpp"

using namespace plumbline;

using Run = test::SimulatedRun<test::RgbdImu, 10, Points<90>>;

TEST_CASE("sliding_window: rgbd-imu/points: errors are consistent with the covariance") {
  test::require_consistent<Run>();
}

TEST_CASE("sliding_window: rgbd-imu/points: half the noise is half the error") {
  test::require_error_follows_noise<Run>();
}

TEST_CASE("sliding_window: rgbd-imu/points: position and heading of the whole stay unknown") {
  test::require_whole_unobservable<Run>();
}
