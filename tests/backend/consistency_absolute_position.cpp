// Positions measured from outside once a second remove the drift of an odometry with large noise, and the covariance
// means what it says.                                                                          docs/math/factors.md
#include <cmath>
#include <cstdint>

#include "backend/consistency.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/factor/absolute_position.hpp"

using namespace plumbline;

namespace {

constexpr int runs = 12, seconds = 24, last_seconds = 6, frames_per_second = test::Consistency::frames_per_second;
/// 99 % of the means of `runs` independent chi-squares of three degrees of freedom, of 36 by 12.
constexpr double runs_low = 1.49, runs_high = 5.13;
constexpr double sigma_position = 0.03;

struct Errors {
  double at_end = 0;                            ///< root mean square over the last seconds [m]
  double nees_position = 0, nees_rotation = 0;  ///< means of the last seconds
  int positions = 0;
};

template <class Policy>
Errors measure(double sigma) {
  test::RunOptions options;
  options.noise = 4;
  options.sigma_position = sigma;
  Errors out;
  constexpr double n = runs * last_seconds * frames_per_second;
  for (int seed = 1; seed <= runs; ++seed) {
    test::BackendRun<Policy, test::MonoImu, Points<90>> run(std::uint64_t(seed), options);
    for (int k = 0; k < seconds * frames_per_second; ++k) {
      const test::FrameError e = run.step();
      if (k < (seconds - last_seconds) * frames_per_second) continue;
      out.at_end += e.position * e.position / n;
      out.nees_position += e.nees_position / n;
      out.nees_rotation += e.nees_rotation / n;
    }
    out.positions += run.positions();
  }
  out.at_end = std::sqrt(out.at_end);
  return out;
}

template <class Policy>
void require_no_drift() {
  const Errors with = measure<Policy>(sigma_position), without = measure<Policy>(0);
  CAPTURE(with.at_end, with.nees_position, with.nees_rotation);
  CAPTURE(without.at_end, without.nees_position, without.nees_rotation);
  CHECK(with.positions == runs * seconds);
  CHECK(without.at_end > 2 * with.at_end);
  CHECK(with.at_end < std::sqrt(3.0) * sigma_position);  // the error of one measured position, in space
  CHECK(with.nees_position > runs_low);
  CHECK(with.nees_position < runs_high);
  CHECK(with.nees_rotation > runs_low);
  CHECK(with.nees_rotation < runs_high);
}

}  // namespace

TEST_CASE("absolute_position: sliding_window: no drift, and errors are consistent with the covariance") {
  require_no_drift<SlidingWindow<8, Flow, AbsolutePosition>>();
}

TEST_CASE("absolute_position: direct_gauss_newton: no drift, and errors are consistent with the covariance") {
  require_no_drift<DirectGaussNewton<8, DirectAlignment, AbsolutePosition>>();
}
