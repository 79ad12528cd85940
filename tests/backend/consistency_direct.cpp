// The direct backend: a camera without depth and an IMU, points.                           docs/math/direct.md
#include "backend/consistency.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"

using namespace plumbline;

using Run = test::BackendRun<DirectGaussNewton<10>, test::MonoImu, Points<90>>;

TEST_CASE("direct_gauss_newton: mono-imu/points: errors are consistent with the covariance") {
  test::require_consistent<Run>();
}

TEST_CASE("direct_gauss_newton: mono-imu/points: half the noise is half the error") {
  test::require_error_follows_noise<Run>();
}

TEST_CASE("direct_gauss_newton: mono-imu/points: position and heading of the whole stay unknown") {
  test::require_whole_unobservable<Run>();
}
