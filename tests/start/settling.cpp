#include "plumbline/start/settling.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05;

/// Frames up to that age [s], of a body as fast as that [m/s], whose readings and images disagree for as long.
Settling seen(double until_s, double speed, double sigma, double disagree_s = 0) {
  Settling settling({.min_s = 3, .max_speed_sigma = 0.02, .speed_noise = 0.01, .max_slow_speed_sigma = 0.05});
  settling.begin();
  for (int k = 1; k * dt <= until_s + dt / 2; ++k) settling.see(k * dt, dt, k * dt < disagree_s + dt / 2, speed, sigma);
  return settling;
}

}  // namespace

TEST_CASE("settling: a scale is certain after some time, and once a speed is known well") {
  CHECK_FALSE(seen(2.9, 1, 0.001).is_certain());
  CHECK(seen(3.1, 1, 0.019).is_certain());
  CHECK_FALSE(seen(30, 1, 0.021).is_certain());
  CHECK(seen(3.1, 0.3, 0.009).is_certain());  // 3 %, but what is left is not the scale's alone
  CHECK_FALSE(seen(30, 0.3, 0.011).is_certain());
  CHECK_FALSE(seen(30, 0.1, 0.006).is_certain());
  CHECK_FALSE(seen(30, 0, 0).is_certain());
  CHECK_FALSE(seen(30, 0, std::numeric_limits<double>::quiet_NaN()).is_certain());
  CHECK_FALSE(seen(30, std::numeric_limits<double>::quiet_NaN(), 0.001).is_certain());
}

TEST_CASE("settling: once it is certain it stays so, until all begins anew") {
  Settling settling = seen(3.1, 1, 0.019);
  settling.see(4, dt, false, 0.01, 0.1);
  CHECK(settling.is_certain());
  settling.see(4.1, 10, true, 1, 0.01);
  CHECK_FALSE(settling.is_refuted());  // what disagrees then is not the start
  settling.begin();
  CHECK_FALSE(settling.is_certain());
}

TEST_CASE("settling: a start that is contradicted for long while it is young was none") {
  CHECK_FALSE(seen(3.1, 1, 0.1, 0.4).is_refuted());
  CHECK(seen(3.1, 1, 0.1, 0.6).is_refuted());
  Settling settling = seen(3.1, 1, 0.1, 0.4);
  settling.see(3.2, 10, true, 1, 0.1);  // too late
  CHECK_FALSE(settling.is_refuted());
  settling.see(1, 0.3, true, 1, 0.1);
  CHECK(settling.is_refuted());
  settling.begin();
  CHECK_FALSE(settling.is_refuted());
}
