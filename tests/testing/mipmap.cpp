#include "plumbline/testing/mipmap.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline::testing;

TEST_CASE("mipmap: a linear ramp is reproduced at every level, without a shift") {
  const Mipmap texture([](float u, float v) { return 40 + 60 * u + 30 * v; }, 2.0f, 1.5f, 0.01f);
  for (const float footprint : {0.004f, 0.013f, 0.05f, 0.12f}) {
    const float value = texture.sample(1.03f, 0.71f, footprint, 0, 0, footprint);
    REQUIRE(value == Approx(40 + 60 * 1.03 + 30 * 0.71).margin(0.8));
  }
}

TEST_CASE("mipmap: a pattern finer than the footprint averages out, one that is coarser stays") {
  const auto stripes = [](float u, float) { return std::fmod(u, 0.08f) < 0.04f ? 200.0f : 0.0f; };
  const Mipmap texture(stripes, 1.28f, 1.28f, 0.005f);
  for (const float u : {0.5f, 0.53f, 0.57f})
    REQUIRE(texture.sample(u, 0.6f, 0.16f, 0, 0, 0.16f) == Approx(100).margin(8));
  REQUIRE(texture.sample(0.5f, 0.6f, 0.002f, 0, 0, 0.002f) == Approx(200).margin(1));  // inside a bright stripe
  REQUIRE(texture.sample(0.54f, 0.6f, 0.002f, 0, 0, 0.002f) == Approx(0).margin(1));
  // seen at a grazing angle ALONG the stripes: the long axis of the footprint must not blur across them
  REQUIRE(texture.sample(0.5f, 0.6f, 0.005f, 0, 0, 0.02f) > 190);
}
