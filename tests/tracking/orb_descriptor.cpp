#include "plumbline/tracking/orb_descriptor.hpp"

#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

OrbDescription described(const cv::Mat& image, const Vec2f& uv) {
  return OrbDescriber::describe(opencv::view<std::uint8_t>(image), uv);
}

std::vector<Vec2f> grid_points(const cv::Mat& image, int step) {
  std::vector<Vec2f> out;
  for (int y = 40; y < image.rows - 40; y += step) {
    for (int x = 40; x < image.cols - 40; x += step) out.emplace_back(float(x), float(y));
  }
  return out;
}

}  // namespace

TEST_CASE("orb descriptor: valid as far as the pattern and the smoothing reach") {
  const cv::Mat image = testing::textured_image(100, 80);
  const float b = OrbDescriber::border_px;
  REQUIRE(described(image, {b, b}).valid);
  REQUIRE(described(image, {99 - b, 79 - b}).valid);
  REQUIRE(!described(image, {b - 0.1f, b}).valid);
  REQUIRE(!described(image, {b, 79.1f - b}).valid);
  REQUIRE(!described(image, {std::numeric_limits<float>::quiet_NaN(), b}).valid);
  REQUIRE(!OrbDescriber::describe({}, {b, b}).valid);
}

TEST_CASE("orb descriptor: of one patch, whatever the stride of its image") {
  const cv::Mat image = testing::textured_image(200, 160);
  const cv::Mat part = image(cv::Rect(30, 20, 100, 90));
  const OrbDescription whole = described(image, {80, 65}), cut = described(part, {50, 45});
  REQUIRE(whole.descriptor == cut.descriptor);
  REQUIRE(whole.angle_rad == cut.angle_rad);
}

TEST_CASE("orb descriptor: a brighter image of more contrast changes few bits") {
  const cv::Mat image = testing::textured_image();
  cv::Mat brighter;
  image.convertTo(brighter, CV_8U, 0.8, 30);
  double bits = 0;
  const std::vector<Vec2f> points = grid_points(image, 40);
  for (const Vec2f& uv : points) {
    bits += hamming_distance(described(image, uv).descriptor, described(brighter, uv).descriptor);
  }
  REQUIRE(bits / double(points.size()) < 8);
}

TEST_CASE("orb descriptor: the angle points to the bright side and turns with the image") {
  cv::Mat ramp(64, 64, CV_8U);
  for (const double degrees : {0.0, 45.0, 90.0, 200.0, 330.0}) {
    const double angle = degrees * 3.14159265358979 / 180;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double along = std::cos(angle) * (x - 32) + std::sin(angle) * (y - 32);
        ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(128 + 2 * along);
      }
    }
    const double error = std::remainder(double(described(ramp, {32, 32}).angle_rad) - angle, 2 * 3.14159265358979);
    REQUIRE(std::abs(error) < 0.03);
  }
}

TEST_CASE("orb descriptor: few bits change under a rotation, half of them between two places") {
  const cv::Mat image = testing::textured_image();
  const std::vector<Vec2f> points = grid_points(image, 32);
  for (const float degrees : {15.0f, 90.0f, 163.0f}) {
    const testing::AffineMotion motion = testing::about_center(image, degrees, 1.0f, Vec2f(3, -2));
    const cv::Mat turned = testing::warped(image, motion, 0.9, 10);
    std::vector<double> same, different;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const OrbDescription here = described(image, points[i]), there = described(turned, motion(points[i]));
      if (!there.valid) continue;
      same.push_back(hamming_distance(here.descriptor, there.descriptor));
      different.push_back(
          hamming_distance(described(image, points[(i + 7) % points.size()]).descriptor, there.descriptor));
    }
    CAPTURE(degrees, same.size());
    REQUIRE(testing::quantile(same, 0.5) < 40);
    REQUIRE(testing::quantile(different, 0.05) > 50);
    REQUIRE(testing::quantile(different, 0.5) > 100);
  }
}

TEST_CASE("orb descriptor: a patch without texture is described, and all its bits are equal") {
  const cv::Mat flat(60, 60, CV_8U, cv::Scalar(77));
  const OrbDescription d = described(flat, {30, 30});
  REQUIRE(d.valid);
  REQUIRE(d.descriptor == BinaryDescriptor{});
}
