#pragma once
// Requirements of a window in simulated runs: errors consistent with the covariance and proportional to the noise, and
// no information about what is not observable.                       docs/math/inertial_window.md, Consistency

#include <cmath>
#include <cstdint>
#include <vector>

#include "backend/simulated_run.hpp"
#include "catch.hpp"

namespace plumbline::test {

constexpr int seeds = 30;
/// 99 % of the means of `seeds` independent chi-squares of three degrees of freedom, chi-square of 90 by 30; of six.
constexpr double band_low = 1.97, band_high = 4.28, extrinsics_low = 4.48, extrinsics_high = 7.76;
constexpr double single_low = 0.46, single_high = 1.79;    ///< of one
constexpr double instant_low = 1.74, instant_high = 4.70;  ///< 99.9 % of three: sixteen are looked at in a run

/// Mean over all seeds, second by second. What is averaged over a second is correlated and spreads less than one
/// instant does, never more: the band of one instant holds it.
struct Consistency {
  static constexpr int frames_per_second = 20;
  std::vector<double> nees_position, nees_rotation;  ///< per second
  double mean_position = 0, mean_rotation = 0;       ///< of all of them
  double extrinsics = 0, time_offset = 0;            ///< of the camera, at the end
};

template <class Run>
Consistency measure_consistency(int seconds, const RunOptions& options = {}) {
  Consistency out;
  out.nees_position.resize(std::size_t(seconds));
  out.nees_rotation.resize(std::size_t(seconds));
  for (int seed = 1; seed <= seeds; ++seed) {
    Run run(std::uint64_t(seed), options);
    for (std::size_t second = 0; second < std::size_t(seconds); ++second) {
      for (int k = 0; k < Consistency::frames_per_second; ++k) {
        const FrameError e = run.step();
        out.nees_position[second] += e.nees_position / (seeds * Consistency::frames_per_second);
        out.nees_rotation[second] += e.nees_rotation / (seeds * Consistency::frames_per_second);
      }
    }
    out.extrinsics += run.nees_extrinsics() / seeds;
    out.time_offset += run.nees_time_offset() / seeds;
  }
  for (const double nees : out.nees_position) out.mean_position += nees / seconds;
  for (const double nees : out.nees_rotation) out.mean_rotation += nees / seconds;
  return out;
}

/// A NaN is in no band. `position_high`: of the position in the world.
template <class Run>
void require_consistent(double position_high = instant_high) {
  const Consistency measured = measure_consistency<Run>(8);
  for (std::size_t second = 0; second < measured.nees_position.size(); ++second) {
    const double position = measured.nees_position[second], rotation = measured.nees_rotation[second];
    CAPTURE(second, position, rotation);
    CHECK(position > instant_low);
    CHECK(position < position_high);
    CHECK(rotation > instant_low);
    CHECK(rotation < instant_high);
  }
  CAPTURE(measured.mean_position, measured.mean_rotation, measured.extrinsics, measured.time_offset);
  CHECK(measured.extrinsics > extrinsics_low);
  CHECK(measured.extrinsics < extrinsics_high);
  CHECK(measured.time_offset > single_low);
  CHECK(measured.time_offset < single_high);
  REQUIRE(measured.mean_position > band_low);
  REQUIRE(measured.mean_position < band_high);
  REQUIRE(measured.mean_rotation > band_low);
  REQUIRE(measured.mean_rotation < band_high);
}

/// Root mean square position error of some runs, in the frame of the first keyframe [m].
template <class Run>
double trajectory_error(double noise) {
  constexpr int runs = 8, frames = 120;
  RunOptions options;
  options.noise = noise;
  double sum = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    Run run(std::uint64_t(seed), options);
    for (int k = 0; k < frames; ++k) {
      const double e = run.step().position;
      sum += e * e;
    }
  }
  return std::sqrt(sum / (runs * frames));
}

/// All is linear in the noise but for the biases at the start, which are as large as ever: half the noise is half the
/// error, and a little less is gained where biases matter.
template <class Run>
void require_error_follows_noise() {
  const double whole = trajectory_error<Run>(1), half = trajectory_error<Run>(0.5),
               quarter = trajectory_error<Run>(0.25);
  CAPTURE(whole, half, quarter);
  REQUIRE(whole < 0.05);
  REQUIRE(whole / half > 1.6);
  REQUIRE(whole / half < 2.5);
  REQUIRE(half / quarter > 1.6);
  REQUIRE(half / quarter < 2.5);
}

/// The first keyframe's place and heading are hardly known, so that any other information about them shows.
template <class Run>
void require_whole_unobservable() {
  RunOptions options;
  options.sigma_first = 0.1;
  Run run(3, options);
  while (run.retirements() < 30) {
    run.step();
    const Vec<double, 4> information = run.information_on_the_whole();
    CAPTURE(run.retirements(), information.transpose());
    REQUIRE(information.maxCoeff() < 1 + 1e-6);
    REQUIRE(information.minCoeff() > 0.5);  // 5 cm of error since the start are little beside 10 cm
  }
}

}  // namespace plumbline::test
