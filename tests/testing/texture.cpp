#include "plumbline/testing/texture.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"

using namespace plumbline::testing;

TEST_CASE("texture: every pattern has a sound mean, and texture where it should") {
  for (int k = 0; k <= int(Pattern::sky); ++k) {
    const Material material{Pattern(k), 0.5f, 0.2f, 11};
    double sum = 0, sum2 = 0;
    constexpr int n = 150;
    for (int i = 0; i < n * n; ++i) {
      const float u = float(i % n) / n * 0.9f, v = float(i / n) / n * 0.6f;
      const double value = double(reflectance(material, u, v, 0.9f, 0.6f));
      REQUIRE(std::isfinite(value));
      REQUIRE((value > -0.6 && value < 1.6));
      REQUIRE(reflectance(material, u, v, 0.9f, 0.6f) == float(value));  // pure
      sum += value, sum2 += value * value;
    }
    const double mean = sum / (n * n), deviation = std::sqrt(sum2 / (n * n) - mean * mean);
    REQUIRE((mean > 0.15 && mean < 0.9));
    if (Pattern(k) != Pattern::plain) REQUIRE(deviation > 0.02);
  }
}

TEST_CASE("texture: value noise is continuous and bounded") {
  float largest = 0;
  for (int i = -4000; i < 4000; ++i) {
    const float x = 0.003f * float(i), a = value_noise(x, 0.37f, 5), b = value_noise(x + 0.001f, 0.37f, 5);
    REQUIRE(std::abs(a - b) < 0.006f);
    largest = std::max(largest, std::abs(a));
  }
  REQUIRE((largest > 0.5f && largest <= 1));
}
