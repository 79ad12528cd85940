#include "plumbline/image/patch.hpp"

#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

constexpr int width = 61, height = 47;

std::vector<std::uint8_t> random_pixels() {
  Random random(7);
  std::vector<std::uint8_t> pixels(width * height);
  for (std::uint8_t& pixel : pixels) pixel = static_cast<std::uint8_t>(random.below(256));
  return pixels;
}

/// Bilinear sample of the image continued by its edge.
double sample(const ImageView<const std::uint8_t>& image, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto at = [&](int u, int v) {
    return double(image(std::clamp(u, 0, width - 1), std::clamp(v, 0, height - 1)));
  };
  const double ax = x - x0, ay = y - y0;
  return (1 - ay) * ((1 - ax) * at(x0, y0) + ax * at(x0 + 1, y0)) +
         ay * ((1 - ax) * at(x0, y0 + 1) + ax * at(x0 + 1, y0 + 1));
}

template <int Size>
void check_everywhere(const ImageView<const std::uint8_t>& image) {
  Random random(11);
  Patch<Size> patch;
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    Vec<float, 2> center(float(random.uniform() * (width - 1)), float(random.uniform() * (height - 1)));
    if (i % 3 == 0) center = center.array().round();
    if (i % 7 == 0) center.x() = i % 2 == 0 ? 0.0f : float(width - 1);
    inside += patch_inside(image, center, Size);
    interpolate_patch<Size>(image, center, patch);
    for (int y = 0; y < Size; ++y) {
      for (int x = 0; x < Size; ++x) {
        const double expected =
            sample(image, double(center.x()) + x - 0.5 * (Size - 1), double(center.y()) + y - 0.5 * (Size - 1));
        REQUIRE(std::abs(patch[y * Size + x] - expected) < 5e-3);
      }
    }
  }
  REQUIRE(inside > 300);
  REQUIRE(inside < 1900);
}

}  // namespace

TEST_CASE("patch: samples are bilinear and repeat the edge outside") {
  const std::vector<std::uint8_t> pixels = random_pixels();
  const ImageView<const std::uint8_t> image{pixels.data(), width, height, width};
  check_everywhere<8>(image);
  check_everywhere<11>(image);
  check_everywhere<14>(image);
}

TEST_CASE("patch: inside means that every neighbor of every sample is a pixel") {
  const std::vector<std::uint8_t> pixels = random_pixels();
  const ImageView<const std::uint8_t> image{pixels.data(), width, height, width};
  REQUIRE(patch_inside(image, Vec<float, 2>(3.5f, 3.5f), 8));
  REQUIRE_FALSE(patch_inside(image, Vec<float, 2>(3.49f, 3.5f), 8));
  REQUIRE(patch_inside(image, Vec<float, 2>(width - 1 - 3.51f, height - 1 - 3.51f), 8));
  REQUIRE_FALSE(patch_inside(image, Vec<float, 2>(width - 1 - 3.5f, 20.0f), 8));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE_FALSE(patch_inside(image, Vec<float, 2>(nan, 20.0f), 8));
  REQUIRE_FALSE(patch_inside(image, Vec<float, 2>(20.0f, nan), 8));
}

TEST_CASE("patch: warped samples lie at center + A D") {
  const std::vector<std::uint8_t> pixels = random_pixels();
  const ImageView<const std::uint8_t> image{pixels.data(), width, height, width};
  Random random(13);
  Patch<6> patch;
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    Mat<float, 2, 2> A;
    for (float& a : A.reshaped()) a = float(4 * random.uniform() - 2);
    const Vec<float, 2> center(float(random.uniform() * width), float(random.uniform() * height));
    if (!interpolate_warped_patch<6>(image, center, A, patch)) continue;
    ++inside;
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 6; ++x) {
        const Vec<double, 2> at = center.cast<double>() + A.cast<double>() * Vec<double, 2>(x - 2.5, y - 2.5);
        REQUIRE(std::abs(patch[y * 6 + x] - sample(image, at.x(), at.y())) < 1e-2);
      }
    }
  }
  REQUIRE(inside > 500);
  const Mat<float, 2, 2> nan = Mat<float, 2, 2>::Constant(std::numeric_limits<float>::quiet_NaN());
  REQUIRE_FALSE(interpolate_warped_patch<6>(image, Vec<float, 2>(20, 20), nan, patch));
}
