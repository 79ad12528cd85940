#include "plumbline/imu/full_scale.hpp"

#include <cmath>
#include <initializer_list>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr double none = std::numeric_limits<double>::infinity();

double quantized(double value, double step) { return step * std::round(value / step); }

/// Samples of a shaken body at 200 Hz, each changed by change(double&).
double found(double seconds, double noise, auto&& change) {
  FullScaleFinder finder({.min_full_scale = 5});
  testing::Gaussian gaussian(3);
  for (int k = 0; k < int(200 * seconds); ++k) {
    const double t = k / 200.0;
    Vec<double, 3> a{9.6 + 2 * std::sin(7 * t), 3 * std::sin(5 * t), 2 * std::cos(3 * t)};
    for (int i = 0; i < 3; ++i) {
      a[i] += noise * gaussian();
      change(a[i]);
    }
    finder.add(a);
  }
  return finder.found();
}

}  // namespace

TEST_CASE("full_scale: clipped samples are detected") {
  for (const double full_scale : {8.0, 9.5, 10.5}) {
    const auto cut = [&](double& a) { a = std::fmin(std::fmax(a, -full_scale), full_scale); };
    REQUIRE(found(12, 0.1, cut) == full_scale);
    const auto coarse = [&](double& a) { a = std::fmin(quantized(a, 0.005), full_scale); };
    REQUIRE(found(12, 0.1, coarse) == full_scale);
  }
}

TEST_CASE("full_scale: samples that are not clipped are not, coarse ones neither") {
  REQUIRE(found(60, 0.1, [](double&) {}) == none);
  REQUIRE(found(60, 0.1, [](double& a) { a = quantized(a, 0.04); }) == none);
  REQUIRE(found(60, 0.02, [](double& a) { a = quantized(a, 0.15); }) == none);
}

TEST_CASE("full_scale: a stationary sensor is not saturated, however coarse") {
  for (const double step : {1e-3, 0.04, 0.15}) {
    for (const double noise : {0.0, 0.01, 0.05, 0.1}) {
      FullScaleFinder finder({.min_full_scale = 5});
      testing::Gaussian gaussian(5);
      for (int k = 0; k < 20000; ++k) {
        const double tilt = k < 10000 ? 0 : 1e-4 * (k - 10000);  // and then is tilted
        finder.add({quantized(9.81 * std::cos(tilt) + noise * gaussian(), step), quantized(noise * gaussian(), step),
                    quantized(9.81 * std::sin(tilt) + noise * gaussian(), step)});
      }
      CAPTURE(step, noise);
      REQUIRE(finder.found() == none);
    }
  }
}

TEST_CASE("full_scale: an exceeded value was no full scale, nor are small values") {
  FullScaleFinder small({.min_full_scale = 5}), finder({.min_full_scale = 5});
  for (int k = 0; k < 40; ++k) {
    small.add({k % 2 == 0 ? -4 : 0.01 * k, 0, 0});
    finder.add({k % 2 == 0 ? -9.5 : 0.01 * k, 0, 0});
  }
  REQUIRE(small.found() == none);
  REQUIRE(finder.found() == 9.5);
  finder.add({0, 9.6, 0});  // the axes are of one kind
  REQUIRE(finder.found() == none);
}

TEST_CASE("full_scale: a sensor that is switched to a smaller range is detected, too") {
  FullScaleFinder finder({.min_full_scale = 5});
  testing::Gaussian gaussian(7);
  for (int k = 0; k < 4000; ++k) {
    const double a = 9.6 + gaussian();
    finder.add({k < 2000 ? a : std::fmin(a, 9.5), 0, 0});
    if (k < 2000) REQUIRE(finder.found() == none);
  }
  REQUIRE(finder.found() == 9.5);
}

TEST_CASE("full_scale: samples that are not finite change nothing") {
  FullScaleFinder finder({.min_full_scale = 5});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k < 40; ++k) finder.add({nan, nan, nan});
  REQUIRE(finder.found() == none);
}
