#include "plumbline/image/pyramid.hpp"

#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

struct TestImage {
  TestImage(int width, int height, int stride) : pixels(static_cast<std::size_t>(stride * height)) {
    view = {pixels.data(), width, height, stride};
  }
  std::vector<std::uint8_t> pixels;
  ImageView<std::uint8_t> view;
};

}  // namespace

TEST_CASE("pyramid: level 0 is the image and each level the rounded mean of four pixels") {
  TestImage image(83, 71, 96);  // odd sides, and a view of a larger image
  Random random(3);
  for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.below(256));
  auto pyramid = std::make_unique<Pyramid<3, 83 * 71>>();
  REQUIRE(pyramid->empty());
  REQUIRE(pyramid->build(image.view));
  REQUIRE_FALSE(pyramid->empty());
  REQUIRE(pyramid->level(0).width == 83);
  REQUIRE(pyramid->level(2).width == 20);
  REQUIRE(pyramid->level(2).height == 17);
  for (int y = 0; y < 71; ++y) {
    for (int x = 0; x < 83; ++x) REQUIRE(pyramid->level(0)(x, y) == image.view(x, y));
  }
  for (int l = 1; l < 3; ++l) {
    const ImageView<const std::uint8_t> fine = pyramid->level(l - 1), coarse = pyramid->level(l);
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        const double mean =
            (fine(2 * x, 2 * y) + fine(2 * x + 1, 2 * y) + fine(2 * x, 2 * y + 1) + fine(2 * x + 1, 2 * y + 1)) / 4.0;
        REQUIRE(coarse(x, y) == static_cast<int>(std::floor(mean + 0.5)));
      }
    }
  }
}

TEST_CASE("pyramid: a linear image keeps its values at the mapped coordinates") {
  TestImage image(128, 128, 128);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) image.view(x, y) = static_cast<std::uint8_t>(x + y);
  }
  auto pyramid = std::make_unique<Pyramid<4, 128 * 128>>();
  REQUIRE(pyramid->build(image.view));
  for (int l = 0; l < 4; ++l) {
    const ImageView<const std::uint8_t> level = pyramid->level(l);
    for (int y = 0; y < level.height; ++y) {
      for (int x = 0; x < level.width; ++x) {
        const Vec<float, 2> uv = from_level(Vec<float, 2>(float(x), float(y)), l);
        REQUIRE(std::abs(float(level(x, y)) - uv.sum()) <= 0.5f);
      }
    }
    const Vec<float, 2> uv(30.25f, 77.5f);
    REQUIRE((from_level(to_level(uv, l), l) - uv).norm() < 1e-5f);
    REQUIRE(to_level(uv, l).x() == Approx((30.25 + 0.5) / (1 << l) - 0.5));
  }
}

TEST_CASE("pyramid: refuses what it cannot hold and is empty then") {
  auto pyramid = std::make_unique<Pyramid<2, 64 * 48>>();
  TestImage good(64, 48, 64), long_one(3072, 1, 3072), large(64, 49, 64), narrow(31, 64, 31);
  REQUIRE(pyramid->build(good.view));
  REQUIRE_FALSE(pyramid->build(large.view));
  REQUIRE(pyramid->empty());
  REQUIRE(pyramid->level(1).empty());
  REQUIRE_FALSE(pyramid->build(long_one.view));
  REQUIRE_FALSE(pyramid->build(narrow.view));
  REQUIRE_FALSE(pyramid->build({}));
  const int huge = std::numeric_limits<int>::max();
  REQUIRE_FALSE(pyramid->build(ImageView<const std::uint8_t>{good.pixels.data(), huge, huge, huge}));
  REQUIRE(pyramid->build(good.view));
}
