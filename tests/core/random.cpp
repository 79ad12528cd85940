#include "plumbline/core/random.hpp"

#include <array>
#include <cmath>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("random: the published splitmix64 sequence") {
  Random random(1234567);
  CHECK(random.next() == 6457827717110365317ull);
  CHECK(random.next() == 3203168211198807973ull);
  CHECK(random.next() == 9817491932198370423ull);
  static_assert(Random(1234567).next() == 6457827717110365317ull);
}

TEST_CASE("random: below is even and stays below") {
  Random random(3);
  std::array<int, 7> histogram{};
  const int draws = 70000;
  for (int i = 0; i < draws; ++i) {
    const std::uint32_t value = random.below(7);
    REQUIRE(value < 7);
    ++histogram[value];
  }
  double chi2 = 0;
  for (const int count : histogram) chi2 += std::pow(count - draws / 7.0, 2) / (draws / 7.0);
  CHECK(chi2 < 22.5);  // 99.9 % of 6 degrees of freedom
  for (int i = 0; i < 100; ++i) REQUIRE(random.below(1) == 0);
}

TEST_CASE("random: uniform has mean 1/2, variance 1/12 and the range [0, 1)") {
  Random random(5);
  double sum = 0, squares = 0;
  const int draws = 100000;
  for (int i = 0; i < draws; ++i) {
    const double value = random.uniform();
    REQUIRE((value >= 0 && value < 1));
    sum += value;
    squares += value * value;
  }
  const double mean = sum / draws;
  CHECK(mean == Approx(0.5).margin(0.004));
  CHECK(squares / draws - mean * mean == Approx(1. / 12).margin(0.002));
}
