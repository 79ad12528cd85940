#include "plumbline/tracking/optical_flow.hpp"

#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::AffineMotion;
using plumbline::testing::Vec2f;

namespace {

using Pyr = Pyramid<4, 1300 * 480>;
using Corners = FixedVector<Corner, 150>;

/// The pyramids of an image and of the image after a motion.
struct Pair {
  Pair(const cv::Mat& image, const AffineMotion& motion_, double gain, double bias, double noise) : motion(motion_) {
    REQUIRE(previous->build(opencv::view<std::uint8_t>(testing::with_noise(image, noise, 1))));
    const cv::Mat moved = testing::warped(image, motion, gain, bias);
    REQUIRE(current->build(opencv::view<std::uint8_t>(testing::with_noise(moved, noise, 2))));
    detect_corners(previous->level(0), nullptr, 0, CornerOptions{}, corners);
  }
  /// The corners that stay `border` pixels inside the current image.
  std::vector<Vec2f> visible(float border) const {
    std::vector<Vec2f> out;
    for (const Corner& corner : corners) {
      const Vec2f uv = motion(corner.uv);
      if (current->level(0).contains(uv.x(), uv.y(), border)) out.push_back(corner.uv);
    }
    return out;
  }
  AffineMotion motion;
  std::unique_ptr<Pyr> previous = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  Corners corners;
};

struct Score {
  std::vector<double> errors;
  std::size_t wrong = 0;  // valid and off by more than 1 px
};

Score score(const Pair& pair, const std::vector<Vec2f>& points, const Vec2f& guess_error) {
  Score out;
  for (const Vec2f& uv : points) {
    const Vec2f truth = pair.motion(uv);
    const FlowResult flow =
        track_point_checked(*pair.previous, *pair.current, uv, truth + guess_error, OpticalFlowOptions{});
    if (!flow.valid) continue;
    out.errors.push_back(double((flow.uv - truth).norm()));
    out.wrong += out.errors.back() > 1.0;
  }
  return out;
}

}  // namespace

TEST_CASE("optical flow: sub-pixel motion under gain and bias") {
  const cv::Mat image = testing::textured_image();
  for (const double gain : {0.8, 1.0, 1.2}) {
    AffineMotion motion;
    motion.t = Vec2f(2.37f, -1.61f);
    const Pair pair(image, motion, gain, 15 * (1 - gain), 1.0);
    const std::vector<Vec2f> points = pair.visible(16);
    REQUIRE(points.size() > 100);
    const Score result = score(pair, points, Vec2f(-2.37f, 1.61f));
    REQUIRE(result.errors.size() > points.size() * 95 / 100);
    REQUIRE(result.wrong == 0);
    REQUIRE(testing::quantile(result.errors, 0.5) < 0.05);
  }
}

TEST_CASE("optical flow: a guess wrong by 25 px converges") {
  const cv::Mat image = testing::textured_image();
  const Pair pair(image, AffineMotion{}, 1.0, 0.0, 1.0);
  const std::vector<Vec2f> points = pair.visible(40);
  REQUIRE(points.size() > 80);
  for (int k = 0; k < 8; ++k) {
    const float angle = 0.785398f * static_cast<float>(k);
    const Score result = score(pair, points, 25.0f * Vec2f(std::cos(angle), std::sin(angle)));
    REQUIRE(result.errors.size() > points.size() * 85 / 100);
    REQUIRE(result.wrong <= points.size() * 2 / 100);
    REQUIRE(testing::quantile(result.errors, 0.5) < 0.05);
  }
}

TEST_CASE("optical flow: recorded images under rotation, scale, brightness and noise", "[data]") {
  if (skip_without(testing::recordings)) return;
  for (const cv::Mat& image : testing::recorded_images()) {
    const AffineMotion motion = testing::about_center(image, 1.0f, 1.01f, Vec2f(5.3f, -3.7f));
    const Pair pair(image, motion, 0.9, 10.0, 1.0);
    const std::vector<Vec2f> points = pair.visible(12);
    REQUIRE(points.size() > 60);
    std::vector<double> errors;
    for (const Vec2f& uv : points) {
      const FlowResult flow = track_point_checked(*pair.previous, *pair.current, uv, uv, OpticalFlowOptions{});
      if (flow.valid) errors.push_back(double((flow.uv - motion(uv)).norm()));
    }
    REQUIRE(errors.size() > points.size() * 85 / 100);
    REQUIRE(testing::quantile(errors, 0.5) < 0.1);
    REQUIRE(testing::quantile(errors, 0.9) < 0.3);
  }
}

TEST_CASE("optical flow: points that have been covered are not tracked") {
  const cv::Mat image = testing::textured_image();
  const cv::Mat cover = testing::textured_image(640, 480, 99);
  Pair pair(image, AffineMotion{}, 1.0, 0.0, 1.0);
  cv::Mat current = image.clone();
  cover(cv::Rect(200, 100, 240, 280)).copyTo(current(cv::Rect(200, 100, 240, 280)));
  REQUIRE(pair.current->build(opencv::view<std::uint8_t>(current)));
  int covered = 0, accepted = 0;
  for (const Vec2f& uv : pair.visible(16)) {
    if (!(uv.x() > 210 && uv.x() < 430 && uv.y() > 110 && uv.y() < 370)) continue;
    ++covered;
    accepted += track_point_checked(*pair.previous, *pair.current, uv, uv, OpticalFlowOptions{}).valid;
  }
  REQUIRE(covered > 20);
  REQUIRE(accepted <= covered / 5);  // some of the new texture looks like the old
}

TEST_CASE("optical flow: the forward-backward check") {
  const cv::Mat image = testing::textured_image();
  AffineMotion motion;
  motion.t = Vec2f(1.3f, 0.4f);
  const Pair pair(image, motion, 1.0, 0.0, 1.0);
  OpticalFlowOptions strict;
  strict.forward_backward_px = 0.0f;
  int accepted = 0;
  for (const Vec2f& uv : pair.visible(16)) {
    REQUIRE(track_point(*pair.previous, *pair.current, uv, uv, strict).valid);
    accepted += track_point_checked(*pair.previous, *pair.current, uv, uv, strict).valid;
  }
  REQUIRE(accepted == 0);
}

TEST_CASE("optical flow: borders, flat images and NaN are refused") {
  const cv::Mat image = testing::textured_image();
  const Pair pair(image, AffineMotion{}, 1.0, 0.0, 0.0);
  const OpticalFlowOptions options;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const Vec2f good = pair.corners[0].uv;
  const auto valid = [&](const Vec2f& uv, const Vec2f& guess) {
    return track_point_checked(*pair.previous, *pair.current, uv, guess, options).valid;
  };
  REQUIRE(valid(good, good));
  for (const Vec2f& bad : {Vec2f(nan, 100), Vec2f(100, nan), Vec2f(infinite, 100), Vec2f(-50, 100), Vec2f(100, 1e9f),
                           Vec2f(3, 100), Vec2f(637, 100)}) {
    REQUIRE_FALSE(valid(bad, good));
    REQUIRE_FALSE(valid(bad, bad));
  }
  REQUIRE_FALSE(valid(good, Vec2f(nan, nan)));
  REQUIRE_FALSE(valid(good, Vec2f(-100, 100)));

  auto flat = std::make_unique<Pyr>();
  REQUIRE(flat->build(opencv::view<std::uint8_t>(cv::Mat(480, 640, CV_8U, cv::Scalar(128)))));
  REQUIRE_FALSE(track_point(*flat, *flat, good, good, options).valid);
  const auto nothing = std::make_unique<Pyr>();
  REQUIRE_FALSE(track_point(*nothing, *flat, good, good, options).valid);
  REQUIRE_FALSE(track_point(*pair.previous, *nothing, good, good, options).valid);
}
