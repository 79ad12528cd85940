#include "plumbline/core/random_sample.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("random_sample: different indices below n, every pair as often") {
  Random random(3);
  std::array<std::array<int, 6>, 6> count{};
  for (int trial = 0; trial < 15000; ++trial) {
    const std::array<std::uint32_t, 2> s = random_sample<2>(random, 6);
    REQUIRE(s[0] != s[1]);
    REQUIRE((s[0] < 6 && s[1] < 6));
    ++count[std::min(s[0], s[1])][std::max(s[0], s[1])];
  }
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i + 1; j < 6; ++j) CHECK(std::abs(count[i][j] - 1000) < 130);  // four sigma
  }
  std::array<std::uint32_t, 5> all = random_sample<5>(random, 5);
  std::sort(all.begin(), all.end());
  CHECK(all == std::array<std::uint32_t, 5>{0, 1, 2, 3, 4});
}

TEST_CASE("random_sample: how many are needed") {
  CHECK(samples_needed(0.99, 1.0, 5) == 0);
  CHECK(std::isinf(samples_needed(0.99, 0.0, 5)));
  CHECK(samples_needed(0.99, 0.5, 3) == Approx(std::log(0.01) / std::log(1 - 0.125)));
  CHECK(samples_needed(0.99, 0.5, 5) > samples_needed(0.99, 0.5, 4));
}
