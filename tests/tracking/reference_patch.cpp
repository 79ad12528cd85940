#include "plumbline/tracking/reference_patch.hpp"

#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

using Pyr = Pyramid<4, 200 * 160>;

std::unique_ptr<Pyr> random_pyramid() {
  std::vector<std::uint8_t> pixels(200 * 160);
  Random random(5);
  for (std::uint8_t& pixel : pixels) pixel = static_cast<std::uint8_t>(random.below(256));
  auto pyramid = std::make_unique<Pyr>();
  REQUIRE(pyramid->build({pixels.data(), 200, 160, 200}));
  return pyramid;
}

}  // namespace

TEST_CASE("reference patch: holds the pixels around the feature on each level") {
  const std::unique_ptr<Pyr> pyramid = random_pyramid();
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Vec<float, 2> uv(float(14 + random.uniform() * 171), float(14 + random.uniform() * 131));
    ReferencePatch patch;
    REQUIRE(patch.levels() == 0);
    REQUIRE(patch.capture(*pyramid, uv));
    REQUIRE(patch.levels() == ReferencePatch::max_levels);
    for (int l = 0; l < patch.levels(); ++l) {
      const ImageView<const std::uint8_t> image = pyramid->level(l);
      const Vec<float, 2> shift = to_level(uv, l) - patch.center(l);  // of the copy in the image
      const int x0 = int(std::lround(shift.x())), y0 = int(std::lround(shift.y()));
      REQUIRE((shift - Vec<float, 2>(float(x0), float(y0))).norm() < 1e-4f);
      REQUIRE((patch.center(l).array() - 0.5f * (ReferencePatch::size - 1)).abs().maxCoeff() <= 0.5f + 1e-4f);
      for (int y = 0; y < ReferencePatch::size; ++y) {
        for (int x = 0; x < ReferencePatch::size; ++x) {
          const int u = std::clamp(x0 + x, 0, image.width - 1), v = std::clamp(y0 + y, 0, image.height - 1);
          REQUIRE(patch.level(l)(x, y) == image(u, v));
        }
      }
    }
  }
}

TEST_CASE("reference patch: a crop holds the pixels around the feature") {
  const std::unique_ptr<Pyr> pyramid = random_pyramid();
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const Vec<float, 2> uv(float(14 + random.uniform() * 171), float(14 + random.uniform() * 131));
    ReferencePatch patch;
    REQUIRE(patch.capture(*pyramid, uv));
    PatchCopy<16, 2> crop;
    crop.crop(patch);
    REQUIRE(crop.levels() == 2);
    for (int l = 0; l < crop.levels(); ++l) {
      const Vec<float, 2> shift = patch.center(l) - crop.center(l);
      const int x0 = int(std::lround(shift.x())), y0 = int(std::lround(shift.y()));
      REQUIRE((shift - Vec<float, 2>(float(x0), float(y0))).norm() < 1e-4f);
      REQUIRE((crop.center(l).array() - 7.5f).abs().maxCoeff() <= 0.5f + 1e-4f);
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) REQUIRE(crop.level(l)(x, y) == patch.level(l)(x0 + x, y0 + y));
      }
    }
  }
  PatchCopy<16, 2> empty;
  empty.crop(ReferencePatch{});
  CHECK(empty.levels() == 0);
}

TEST_CASE("reference patch: too near to the border, NaN and empty pyramids are refused") {
  const std::unique_ptr<Pyr> pyramid = random_pyramid();
  ReferencePatch patch;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Vec<float, 2>& uv : {Vec<float, 2>(12.9f, 80), Vec<float, 2>(100, 12.9f), Vec<float, 2>(186.1f, 80),
                                  Vec<float, 2>(100, 146.1f), Vec<float, 2>(nan, 80), Vec<float, 2>(-1e9f, 80)}) {
    REQUIRE(patch.capture(*pyramid, Vec<float, 2>(100, 80)));
    REQUIRE_FALSE(patch.capture(*pyramid, uv));
    REQUIRE(patch.levels() == 0);
  }
  REQUIRE_FALSE(patch.capture(*std::make_unique<Pyr>(), Vec<float, 2>(100, 80)));
  static_assert(sizeof(ReferencePatch) < 2500);
}
