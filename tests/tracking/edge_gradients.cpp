#include "plumbline/tracking/edge_gradients.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;

namespace {
using Map = EdgeMap<640 * 480>;
}  // namespace

TEST_CASE("edge_gradients: the same numbers as the map's, border and outside included") {
  const cv::Mat whole = testing::with_noise(testing::textured_image(), 20.0, 3);
  const auto map = std::make_unique<Map>();
  for (const cv::Rect& part : {cv::Rect(0, 0, 640, 480), cv::Rect(5, 7, 301, 111), cv::Rect(1, 1, 7, 7)}) {
    const cv::Mat copy = whole(part).clone();  // no pixel beyond the image may be read: a sanitizer checks it
    const ImageView<const std::uint8_t> image = opencv::view<std::uint8_t>(copy);
    REQUIRE(map->compute(image, 0));
    const EdgeGradients gradients(image);
    REQUIRE(gradients.width() == image.width);
    REQUIRE(gradients.height() == image.height);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const EdgeGradient a = map->gradient(x, y), b = gradients.gradient(x, y);
        if (a.x != b.x || a.y != b.y) FAIL(x << ' ' << y);
      }
    }
    for (float angle = 0; angle < 6; angle += 0.7f) {
      const Vec<float, 2> normal(std::cos(angle), std::sin(angle));
      for (const Vec<float, 2>& at : {Vec<float, 2>(3.2f, 3.4f), Vec<float, 2>(60, 50), Vec<float, 2>(-5, 4)}) {
        float a[41], b[41];
        map->aligned_slopes(at, normal, 20, a);
        gradients.aligned_slopes(at, normal, 20, b);
        for (int j = 0; j < 41; ++j) REQUIRE(a[j] == b[j]);
      }
    }
    for (const EdgePixel& pixel : {EdgePixel{3, 3}, EdgePixel{static_cast<std::int16_t>(image.width - 4), 3}}) {
      REQUIRE(map->peak(pixel) == gradients.peak(pixel));
    }
  }
}

TEST_CASE("edge_gradients: an image without an inside contains nothing") {
  const cv::Mat pixels(6, 50, CV_8U, cv::Scalar(0));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& image : {opencv::view<std::uint8_t>(pixels), ImageView<const std::uint8_t>{}}) {
    const EdgeGradients gradients(image);
    REQUIRE_FALSE(gradients.contains({3, 3}));
    REQUIRE(gradients.aligned_slope({3, 3}, {1, 0}) == 0);
    REQUIRE(gradients.aligned_slope({nan, nan}, {1, 0}) == 0);
    REQUIRE(gradients.gradient(3, 3).strength() == 0);
  }
}

TEST_CASE("edge_gradients: none where a mask excludes, as in the map") {
  const cv::Mat pixels = testing::with_noise(testing::textured_image(), 20.0, 3);
  const ImageView<const std::uint8_t> image = opencv::view<std::uint8_t>(pixels);
  cv::Mat used(pixels.size(), CV_8U, cv::Scalar(255));
  used.rowRange(300, 400).setTo(0);
  const auto mask = std::make_unique<ImageMask<640 * 480>>();
  REQUIRE(mask->set(opencv::view<std::uint8_t>(used)));
  const auto map = std::make_unique<Map>(), whole = std::make_unique<Map>();
  REQUIRE(map->compute(image, 1.6f, mask->view()));
  REQUIRE(whole->compute(image, 1.6f));
  const EdgeGradients gradients(image, mask->view());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool is_excluded = mask->view().excludes(x, y);
      const EdgeGradient expected = is_excluded ? EdgeGradient{0, 0} : whole->gradient(x, y);
      const int strength = is_excluded ? 0 : whole->strength(whole->index(x, y));
      for (const EdgeGradient& g : {map->gradient(x, y), gradients.gradient(x, y)})
        if (g.x != expected.x || g.y != expected.y) FAIL(x << ' ' << y);
      if (map->strength(map->index(x, y)) != strength) FAIL(x << ' ' << y);
    }
  }
}
