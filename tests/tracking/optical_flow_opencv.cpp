// The flow against OpenCV's on recorded images with a known motion: the same points, frames and forward-backward check.
#include <memory>
#include <vector>

#include <opencv2/video/tracking.hpp>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

TEST_CASE("optical flow: not worse than OpenCV's on recorded images", "[data]") {
  if (skip_without(testing::recordings)) return;
  const std::vector<cv::Mat> images = testing::recorded_images();
  using Pyr = Pyramid<4, 1300 * 480>;
  const auto previous = std::make_unique<Pyr>(), current = std::make_unique<Pyr>();
  std::vector<double> all_theirs, all_ours;
  for (const cv::Mat& image : images) {
    for (const float degrees : {0.0f, 2.0f}) {
      const testing::AffineMotion motion = testing::about_center(image, degrees, 1.0f, Vec2f(6.4f, -4.3f));
      const cv::Mat before = testing::with_noise(image, 1.5, 1);
      const cv::Mat after = testing::with_noise(testing::warped(image, motion), 1.5, 2);
      std::vector<cv::Point2f> corners, there, back;
      cv::goodFeaturesToTrack(before, corners, 150, 0.01, 15);
      std::vector<unsigned char> forward_found, backward_found;
      std::vector<float> unused;
      cv::calcOpticalFlowPyrLK(before, after, corners, there, forward_found, unused, {21, 21}, 3);
      cv::calcOpticalFlowPyrLK(after, before, there, back, backward_found, unused, {21, 21}, 3);
      REQUIRE(previous->build(opencv::view<std::uint8_t>(before)));
      REQUIRE(current->build(opencv::view<std::uint8_t>(after)));

      std::vector<double> theirs, ours;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2f uv(corners[i].x, corners[i].y), truth = motion(uv);
        if (!current->level(0).contains(truth.x(), truth.y(), 12.0f) ||
            !current->level(0).contains(uv.x(), uv.y(), 12.0f)) {
          continue;
        }
        if (forward_found[i] && backward_found[i] && cv::norm(back[i] - corners[i]) <= 0.5) {
          theirs.push_back(double((Vec2f(there[i].x, there[i].y) - truth).norm()));
        }
        const FlowResult flow = track_point_checked(*previous, *current, uv, uv, OpticalFlowOptions{});
        if (flow.valid) ours.push_back(double((flow.uv - truth).norm()));
      }
      REQUIRE(theirs.size() > 50);
      INFO("ours " << ours.size() << " median " << testing::quantile(ours, 0.5) << " p90 "
                   << testing::quantile(ours, 0.9) << "; OpenCV " << theirs.size() << " median "
                   << testing::quantile(theirs, 0.5) << " p90 " << testing::quantile(theirs, 0.9));
      REQUIRE(ours.size() > theirs.size() * 85 / 100);
      REQUIRE(testing::quantile(ours, 0.5) <= testing::quantile(theirs, 0.5));
      all_theirs.insert(all_theirs.end(), theirs.begin(), theirs.end());
      all_ours.insert(all_ours.end(), ours.begin(), ours.end());
    }
  }
  INFO("all: ours " << all_ours.size() << " of " << all_theirs.size() << ", p90 " << testing::quantile(all_ours, 0.9)
                    << " of " << testing::quantile(all_theirs, 0.9));
  REQUIRE(all_ours.size() > all_theirs.size() * 95 / 100);
  REQUIRE(testing::quantile(all_ours, 0.9) <= testing::quantile(all_theirs, 0.9));
}
