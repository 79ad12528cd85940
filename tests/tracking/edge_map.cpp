#include "plumbline/tracking/edge_map.hpp"

#include <memory>
#include <set>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {
using Map = EdgeMap<640 * 480>;
constexpr int smooth[5] = {1, 4, 6, 4, 1}, slope[5] = {-1, -2, 0, 2, 1};
}  // namespace

TEST_CASE("edge_map: gradients as they are defined, in every part of an image of odd size") {
  const cv::Mat whole = testing::with_noise(testing::textured_image(), 20.0, 3);
  const auto map = std::make_unique<Map>();
  for (const cv::Rect& part : {cv::Rect(0, 0, 640, 480), cv::Rect(5, 7, 301, 111), cv::Rect(1, 1, 7, 7)}) {
    const ImageView<const std::uint8_t> image = opencv::view<std::uint8_t>(whole(part));
    REQUIRE(map->compute(image, 500 / Map::units));
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const int i = map->index(x, y);
        if (!image.contains(x, y, int(Map::border))) {
          REQUIRE(map->strength(i) == 0);
          continue;
        }
        int gx = 0, gy = 0;
        for (int v = 0; v < 5; ++v) {
          for (int u = 0; u < 5; ++u) {
            gx += smooth[v] * slope[u] * image(x + u - 2, y + v - 2);
            gy += smooth[u] * slope[v] * image(x + u - 2, y + v - 2);
          }
        }
        const int s = std::abs(gx) + std::abs(gy);
        if (map->gx(i) != gx || map->gy(i) != gy || map->strength(i) != (s > 500 ? s : 0)) FAIL(x << ' ' << y);
      }
    }
  }
}

TEST_CASE("edge_map: the unit is 128 for a gray level per pixel, and nothing overflows") {
  cv::Mat ramp(40, 60, CV_8U), steps(40, 60, CV_8U);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(3 * x + y);
      steps.at<std::uint8_t>(y, x) = x + y < 50 ? 0 : 255;
    }
  }
  const auto map = std::make_unique<Map>();
  REQUIRE(map->compute(opencv::view<std::uint8_t>(ramp), 0));
  REQUIRE(map->gx(map->index(30, 20)) == int(3 * Map::units));
  REQUIRE(map->gy(map->index(30, 20)) == int(Map::units));
  REQUIRE(map->compute(opencv::view<std::uint8_t>(steps), 0));
  for (int x = 3; x < 57; ++x) REQUIRE(map->gx(map->index(x, 20)) >= 0);
  REQUIRE(map->strength(map->index(30, 20)) > 10000);
}

TEST_CASE("edge_map: chains are connected, keep the bright side on one hand and share no pixel") {
  const auto map = std::make_unique<Map>();
  const auto chain = std::make_unique<EdgeChain>();
  const cv::Mat image = testing::with_noise(testing::textured_image(), 2.0, 3);
  REQUIRE(map->compute(opencv::view<std::uint8_t>(image), 300 / Map::units));
  std::set<std::pair<int, int>> taken;
  std::size_t chains = 0, turns = 0, steps = 0;
  map->for_each_chain(4, *chain, [&](const EdgeChain& c) {
    ++chains;
    REQUIRE(!c.empty());
    for (std::size_t i = 0; i < c.size(); ++i) {
      REQUIRE(taken.insert({c[i].x, c[i].y}).second);
      REQUIRE(map->strength(map->index(c[i].x, c[i].y)) < 0);
      if (i == 0) continue;
      const int dx = c[i].x - c[i - 1].x, dy = c[i].y - c[i - 1].y, j = map->index(c[i].x, c[i].y);
      REQUIRE(std::max(std::abs(dx), std::abs(dy)) == 1);
      ++steps;
      turns += -dy * map->gx(j) + dx * map->gy(j) < 0;  // normal (-dy, dx) against the gradient
    }
  });
  REQUIRE(chains > 100);
  REQUIRE(steps > 5000);
  REQUIRE(turns < steps / 50);
}

TEST_CASE("edge_map: peaks lie on the edge") {
  const auto map = std::make_unique<Map>();
  const auto chain = std::make_unique<EdgeChain>();
  for (float shift = 0; shift < 1; shift += 0.17f) {
    cv::Mat drawn(120, 160, CV_32F, cv::Scalar(60)), image;
    const auto shape = testing::Quadrilateral::rectangle(Vec2f(80 + shift, 60), 70, 60, 0);
    testing::draw(drawn, shape, 100);
    drawn.convertTo(image, CV_8U);
    REQUIRE(map->compute(opencv::view<std::uint8_t>(image), 500 / Map::units));
    int checked = 0;
    map->for_each_chain(4, *chain, [&](const EdgeChain& c) {
      for (const EdgePixel& pixel : c) {
        if (std::abs(pixel.y - 60) > 20) continue;
        const float x = map->peak(pixel).x(), edge = pixel.x < 80 ? 45 + shift : 115 + shift;
        REQUIRE(std::abs(x - edge) < 0.07f);
        ++checked;
      }
    });
    REQUIRE(checked >= 80);
  }
}

TEST_CASE("edge_map: images that do not fit are refused") {
  const auto map = std::make_unique<EdgeMap<100 * 100>>();
  const cv::Mat image(101, 101, CV_8U, cv::Scalar(0));
  const ImageView<const std::uint8_t> whole = opencv::view<std::uint8_t>(image);
  REQUIRE_FALSE(map->compute(whole, 100));
  REQUIRE_FALSE(map->compute({}, 100));
  REQUIRE_FALSE(map->compute({whole.data, 6, 50, whole.stride}, 100));
  REQUIRE(map->compute({whole.data, 100, 100, whole.stride}, 100));
}
