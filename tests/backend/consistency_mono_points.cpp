// A camera without depth and an IMU, points.                                               docs/math/inertial_window.md
#include <array>
#include <cstdint>

#include "backend/consistency.hpp"

using namespace plumbline;

using Run = test::SimulatedRun<test::MonoImu, 10, Points<90>>;

TEST_CASE("sliding_window: mono-imu/points: errors are consistent with the covariance") {
  test::require_consistent<Run>();
}

TEST_CASE("sliding_window: mono-imu/points: half the noise is half the error") {
  test::require_error_follows_noise<Run>();
}

TEST_CASE("sliding_window: mono-imu/points: position and heading of the whole stay unknown") {
  test::require_whole_unobservable<Run>();
}

TEST_CASE("sliding_window: mono-imu/points: a scale that is wrong at first is as uncertain as it is wrong") {
  test::RunOptions options;
  options.start_scale_sigma = 0.15;
  options.start_tilt = 0.03;
  options.start_keyframes = 9;
  options.frames_per_keyframe = 2;
  constexpr int frames = 40, every = 10;
  std::array<double, frames / every> nees{};
  for (int seed = 1; seed <= test::seeds; ++seed) {
    Run run(std::uint64_t(seed), options);
    for (int k = 0; k < frames; ++k) {
      run.step();
      if (k % every == 0) nees[std::size_t(k / every)] += run.nees_speed() / test::seeds;
    }
  }
  for (const double mean : nees) {
    CHECK(mean > test::single_low);
    CHECK(mean < test::single_high);
  }
}
