#include "plumbline/tracking/corner_maxima.hpp"

#include <algorithm>
#include <memory>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;
using Corners = FixedVector<Corner, 200>;

TEST_CASE("corner maxima: the corners of rectangles, whatever tile they are in") {
  cv::Mat image(200, 300, CV_8U, cv::Scalar(60));
  std::vector<Vec2f> truth;
  for (int y = 30; y < 160; y += 37) {
    for (int x = 30; x < 260; x += 41) {
      image(cv::Rect(x, y, 16, 16)) = 200;
      for (const int dx : {0, 15}) {
        for (const int dy : {0, 15}) truth.emplace_back(float(x + dx), float(y + dy));
      }
    }
  }
  const auto corners = std::make_unique<Corners>();
  detect_corner_maxima(opencv::view<std::uint8_t>(testing::with_noise(image, 1, 3)), {}, {.min_score = 20}, 200,
                       *corners);
  std::size_t found = 0;
  for (const Vec2f& uv : truth) {
    found += std::any_of(corners->begin(), corners->end(), [&](const Corner& c) { return (c.uv - uv).norm() < 3; });
  }
  REQUIRE(found == truth.size());
  REQUIRE(corners->size() < truth.size() * 11 / 10);
}

TEST_CASE("corner maxima: the strongest ones, strongest first, apart from each other, the border and what is there") {
  const cv::Mat image = testing::textured_image();
  const auto all = std::make_unique<FixedVector<Corner, 3000>>();
  const auto some = std::make_unique<Corners>();
  const CornerMaximaOptions options;
  detect_corner_maxima(opencv::view<std::uint8_t>(image), {}, options, 3000, *all);
  detect_corner_maxima(opencv::view<std::uint8_t>(image), {}, options, 50, *some);
  REQUIRE(all->size() > 200);
  REQUIRE(some->size() == 50);
  for (std::size_t i = 0; i < some->size(); ++i) {
    REQUIRE((*some)[i].score == (*all)[i].score);
    REQUIRE((i == 0 || (*some)[i].score <= (*some)[i - 1].score));
  }
  for (const Corner& a : *all) {
    const float border = float(options.border_px) - 0.5f;  // (2a) moves it by at most half a pixel
    REQUIRE(opencv::view<std::uint8_t>(image).contains(a.uv.x(), a.uv.y(), border));
    const auto near = [&](const Corner& b) { return (a.uv - b.uv).cwiseAbs().maxCoeff() <= options.radius_px; };
    REQUIRE(std::count_if(all->begin(), all->end(), near) == 1);  // itself
  }
  const std::vector<Vec2f> existing = {(*all)[0].uv, (*all)[3].uv};
  detect_corner_maxima(opencv::view<std::uint8_t>(image), existing, options, 50, *some);
  for (const Corner& corner : *some) {
    for (const Vec2f& uv : existing) REQUIRE((corner.uv - uv).norm() >= options.distance_px);
  }
}

TEST_CASE("corner maxima: none in a flat image, in a small one, or when none is asked for") {
  const auto corners = std::make_unique<Corners>();
  const cv::Mat flat(100, 100, CV_8U, cv::Scalar(90)), texture = testing::textured_image(120, 47);
  detect_corner_maxima(opencv::view<std::uint8_t>(flat), {}, {}, 100, *corners);
  REQUIRE(corners->empty());
  detect_corner_maxima(opencv::view<std::uint8_t>(texture), {}, {}, 100, *corners);
  REQUIRE(corners->empty());
  detect_corner_maxima(opencv::view<std::uint8_t>(testing::textured_image()), {}, {}, 0, *corners);
  REQUIRE(corners->empty());
}
