#include "plumbline/image/image_mask.hpp"

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>

#include "catch.hpp"
#include "plumbline/testing/simulated_camera.hpp"

using namespace plumbline;

namespace {

constexpr int width = 70, height = 50;
using Mask = ImageMask<width * height>;

testing::Image<std::uint8_t> all(std::uint8_t value) {
  testing::Image<std::uint8_t> out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) out.view()(x, y) = value;
  }
  return out;
}

}  // namespace

TEST_CASE("image_mask: excludes the zero pixels and those within the margin of one, in x and in y") {
  testing::Image<std::uint8_t> image = all(1);
  image.view()(0, 49) = image.view()(30, 20) = image.view()(36, 20) = 0;
  const auto mask = std::make_unique<Mask>();
  REQUIRE(mask->set(image.view()));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto is_near = [&](int u, int v) {
        return std::abs(x - u) <= Mask::margin_px && std::abs(y - v) <= Mask::margin_px;
      };
      const bool expected = is_near(0, 49) || is_near(30, 20) || is_near(36, 20);
      if (mask->view().excludes(x, y) != expected) FAIL(x << ' ' << y);
    }
  }
}

TEST_CASE("image_mask: a position is in its nearest pixel; outside the image and NaN are not excluded") {
  testing::Image<std::uint8_t> image = all(255);
  image.view()(30, 20) = 0;
  const auto mask = std::make_unique<Mask>();
  REQUIRE(mask->set(image.view()));
  const float end = 30 + Mask::margin_px, nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE(mask->view().excludes({end + 0.49f, 20}));
  REQUIRE_FALSE(mask->view().excludes({end + 0.51f, 20}));
  const testing::Image<std::uint8_t> nothing = all(0);
  REQUIRE(mask->set(nothing.view()));
  REQUIRE(mask->view().excludes({-0.4f, 49.4f}));
  for (const Vec<float, 2>& uv : {Vec<float, 2>(-0.6f, 5), Vec<float, 2>(5, 49.6f), Vec<float, 2>(69.6f, 5),
                                  Vec<float, 2>(nan, 5), Vec<float, 2>(5, nan)})
    REQUIRE_FALSE(mask->view().excludes(uv));
}

TEST_CASE("image_mask: an empty image removes it, one that is too large is refused") {
  const auto mask = std::make_unique<Mask>();
  REQUIRE(mask->view().empty());
  const testing::Image<std::uint8_t> nothing = all(0), large(width, height + 1);
  REQUIRE(mask->set(nothing.view()));
  REQUIRE_FALSE(mask->view().empty());
  REQUIRE(mask->set({}));
  REQUIRE(mask->view().empty());
  REQUIRE_FALSE(mask->view().excludes(3, 3));
  REQUIRE_FALSE(mask->set(large.view()));
  REQUIRE(mask->view().empty());
}
