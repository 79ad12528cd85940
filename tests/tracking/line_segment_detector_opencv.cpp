// The edges that OpenCV's LSD finds, as an oracle: long ones must be found here as well.
#include "plumbline/tracking/line_segment_detector.hpp"

#include <iostream>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

std::vector<LineSegment> lsd_segments(const cv::Mat& image) {
  std::vector<cv::Vec4f> found;
  try {
    cv::createLineSegmentDetector()->detect(image, found);
  } catch (const cv::Exception&) {  // versions 3.4.6 to 4.5.3 were built without it
    return {};
  }
  std::vector<LineSegment> out;
  for (const cv::Vec4f& s : found) out.push_back({Vec2f(s[0], s[1]), Vec2f(s[2], s[3]), 0});
  return out;
}

/// Part of `truth` that the segments along it cover, whatever their direction.
float covered(const LineSegment& truth, const LineSegment* begin, const LineSegment* end) {
  constexpr int samples = 50;
  int hits = 0;
  for (int k = 0; k < samples; ++k) {
    const Vec2f at = truth.start + (static_cast<float>(k) + 0.5f) / samples * (truth.end - truth.start);
    hits += std::any_of(begin, end, [&](const LineSegment& s) {
      const float along = s.direction().dot(at - s.start);
      return std::abs(s.direction().dot(truth.direction())) > 0.998f && std::abs(s.distance(at)) < 1.5f && along > -2 &&
             along < s.length() + 2;
    });
  }
  return static_cast<float>(hits) / samples;
}

}  // namespace

TEST_CASE("line_segment_detector: finds what LSD finds", "[data]") {
  if (skip_without(testing::recordings)) return;
  const auto edges = std::make_unique<EdgeMap<1300 * 480>>();
  const auto detector = std::make_unique<LineSegmentDetector<800>>();
  const auto found = std::make_unique<FixedVector<LineSegment, 800>>();
  for (const cv::Mat& image : testing::recorded_images()) {
    const std::vector<LineSegment> lsd = lsd_segments(image);
    if (lsd.empty()) {
      WARN("this OpenCV has no LSD");
      return;
    }
    REQUIRE(edges->compute(opencv::view<std::uint8_t>(image), LineDetectorOptions{}.min_gradient));
    detector->detect(*edges, LineDetectorOptions{}, *found);
    float length = 0, hit = 0, own = 0, own_hit = 0;
    for (const LineSegment& s : lsd) {
      if (s.length() < 50) continue;
      length += s.length();
      hit += s.length() * covered(s, found->begin(), found->end());
    }
    for (const LineSegment& s : *found) {
      if (s.length() < 50 || s.gradient < 6) continue;  // LSD leaves faint edges out
      own += s.length();
      own_hit += s.length() * covered(s, lsd.data(), lsd.data() + lsd.size());
    }
    CAPTURE(length, hit / length, own, own_hit / own, found->size(), lsd.size());
    std::cout << image.size() << ": " << lsd.size() << " by LSD, " << found->size() << " here; of LSD's length found "
              << hit / length << ", of the clear ones here found by LSD " << own_hit / own << '\n';
    REQUIRE(hit > 0.7f * length);
    REQUIRE(own_hit > 0.6f * own);
  }
}
