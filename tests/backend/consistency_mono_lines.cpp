// A camera without depth and an IMU, points and lines.                                     docs/math/inertial_window.md
#include "backend/consistency.hpp"

using namespace plumbline;

using Run = test::SimulatedRun<test::MonoImu, 10, Points<90>, Lines<30>>;

TEST_CASE("sliding_window: mono-imu/points+lines: errors are consistent with the covariance") {
  test::require_consistent<Run>();
}

TEST_CASE("sliding_window: mono-imu/points+lines: position and heading of the whole stay unknown") {
  test::require_whole_unobservable<Run>();
}
