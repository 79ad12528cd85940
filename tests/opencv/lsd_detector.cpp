// LSD and the library's own detector find the same edges, at the same places, in the same direction.
#include "plumbline/opencv/lsd_detector.hpp"

#include <iostream>
#include <memory>

#include "catch.hpp"
#include "plumbline/tracking/line_tracking.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

using Segments = FixedVector<LineSegment, 300>;
using Edges = EdgeMap<1300 * 480>;

template <class Detector>
Segments detect(const cv::Mat& image, const LineDetectorOptions& options = {}) {
  static const auto edges = std::make_unique<Edges>();
  static const auto detector = std::make_unique<Detector>();
  Segments out;
  REQUIRE(edges->compute(opencv::view<std::uint8_t>(image), options.min_gradient));
  detector->detect(opencv::view<std::uint8_t>(image), *edges, options, out);
  return out;
}

/// LSD without the smaller image.
struct FullSize : opencv::LsdParameters {
  FullSize() { scale = 1; }
};
using Own = LineSegmentDetector<>;
using Lsd = opencv::LsdDetector<>;
using LsdFullSize = opencv::LsdDetector<FullSize>;

/// Rectangle i of a series at many angles.
testing::Quadrilateral rectangle(int i) {
  const float shift = 0.37f * static_cast<float>(i);
  return testing::Quadrilateral::rectangle(Vec2f(160 + shift, 118 - shift), 120, 80, 0.2731f * static_cast<float>(i));
}

cv::Mat drawn(const testing::Quadrilateral& shape, double noise) {
  cv::Mat sum(240, 320, CV_32F, cv::Scalar(90)), image;
  testing::draw(sum, shape, 60);
  cv::GaussianBlur(sum, sum, {5, 5}, 0.6);
  sum.convertTo(image, CV_8U);
  return testing::with_noise(image, noise, 3);
}

/// Both ends of `s` lie on the edge, and its direction is that of the edge.
bool lies_on(const LineSegment& s, const LineSegment& edge, float distance_px) {
  return testing::angle_between(s, edge) < 0.05f && std::abs(edge.distance(s.start)) < distance_px &&
         std::abs(edge.distance(s.end)) < distance_px;
}

/// Part of `s` that the others cover, in its direction.
float covered(const LineSegment& s, const Segments& others) {
  constexpr int samples = 50;
  int hits = 0;
  for (int k = 0; k < samples; ++k) {
    const Vec2f at = s.start + (static_cast<float>(k) + 0.5f) / samples * (s.end - s.start);
    hits += std::any_of(others.begin(), others.end(), [&](const LineSegment& other) {
      const float along = other.direction().dot(at - other.start);
      return other.direction().dot(s.direction()) > 0.998f && std::abs(other.distance(at)) < 1.5f && along > -2 &&
             along < other.length() + 2;
    });
  }
  return static_cast<float>(hits) / samples;
}

}  // namespace

TEMPLATE_TEST_CASE("lsd_detector: edges of known geometry", "", Own, Lsd, LsdFullSize) {
  for (const double noise : {0.0, 3.0}) {
    double worst_px = 0, least_covered = 1;
    Vec<double, 2> shift = Vec<double, 2>::Zero();
    int found = 0, on_none = 0;
    for (int i = 0; i < 24; ++i) {
      const testing::Quadrilateral shape = rectangle(i);
      const Segments segments = detect<TestType>(drawn(shape, noise));
      on_none += static_cast<int>(segments.size());
      for (std::size_t k = 0; k < 4; ++k) {
        const LineSegment edge = shape.edge(k);
        least_covered = std::min(least_covered, double(covered(edge, segments)));
        for (const LineSegment& s : segments) {
          if (!lies_on(s, edge, 3)) continue;
          ++found;
          --on_none;
          worst_px =
              std::max({worst_px, double(std::abs(edge.distance(s.start))), double(std::abs(edge.distance(s.end)))});
          shift += (edge.distance(s.center()) * edge.normal()).cast<double>();
          REQUIRE(s.gradient > 10);  // 60 gray levels over about 3 px
          REQUIRE(s.gradient < 30);
        }
      }
    }
    shift *= 2.0 / found;  // every direction: half of a shift is across
    CAPTURE(noise, worst_px, least_covered, shift, found, on_none);
    std::cout << "noise " << noise << ": across " << worst_px << " px, covered " << least_covered << ", common shift "
              << shift.transpose() << " px, " << found << " segments on 96 edges\n";
    REQUIRE(least_covered > (noise > 0 ? 0.6 : 0.9));  // noise splits edges for LSD on the image in full size
    REQUIRE(on_none == 0);
    REQUIRE(worst_px < 0.3);
    REQUIRE(shift.norm() < 0.04);  // 0.18 for LSD without (33)
  }
}

TEST_CASE("lsd_detector: longest first, the longest when there is little room, none too short") {
  cv::Mat sum(240, 320, CV_32F, cv::Scalar(90)), image;
  for (int i = 0; i < 5; ++i) {
    const float size = 20 + 8 * static_cast<float>(i), x = 30 + 62 * static_cast<float>(i);
    testing::draw(sum, testing::Quadrilateral::rectangle(Vec2f(x, 120), size, 2 * size, 0.1f), 70);
  }
  sum.convertTo(image, CV_8U);
  const Segments all = detect<Lsd>(image);
  REQUIRE(all.size() > 12);
  for (std::size_t i = 1; i < all.size(); ++i) REQUIRE(all[i].length() <= all[i - 1].length());
  FixedVector<LineSegment, 6> few;
  opencv::LsdDetector<opencv::LsdParameters, 12>().detect(opencv::view<std::uint8_t>(image), LineDetectorOptions{},
                                                          few);
  REQUIRE(few.size() == 6);
  for (std::size_t i = 0; i < few.size(); ++i) REQUIRE(few[i].length() == Approx(all[i].length()));
  LineDetectorOptions options;
  options.min_length_px = 60;
  const Segments some = detect<Lsd>(image, options);
  REQUIRE((!some.empty() && some.size() < all.size()));
  for (const LineSegment& s : some) REQUIRE(s.length() >= 60);
}

TEST_CASE("lsd_detector: nothing in a flat image or in none") {
  REQUIRE(detect<Lsd>(cv::Mat(240, 320, CV_8U, cv::Scalar(128))).empty());
  Segments out;
  out.push_back({});
  Lsd().detect(ImageView<const std::uint8_t>(), LineDetectorOptions{}, out);
  REQUIRE(out.empty());
}

TEST_CASE("lsd_detector: clear edges of recorded images are found by both, and can be followed", "[data]") {
  if (skip_without(testing::recordings)) return;
  for (const cv::Mat& image : testing::recorded_images()) {
    const Segments own = detect<Own>(image), lsd = detect<Lsd>(image);
    float own_px = 0, own_by_lsd_px = 0, lsd_px = 0, lsd_by_own_px = 0;
    for (const LineSegment& s : own) {
      if (s.length() < 50 || s.gradient < 6) continue;  // LSD leaves faint edges out
      own_px += s.length();
      own_by_lsd_px += s.length() * covered(s, lsd);
    }
    const auto edges = std::make_unique<Edges>();
    edges->compute(opencv::view<std::uint8_t>(image), LineDetectorOptions{}.min_gradient);
    LineTracker tracker;
    int long_ones = 0, followed = 0;
    for (const LineSegment& s : lsd) {
      if (s.length() < 50) continue;
      lsd_px += s.length();
      lsd_by_own_px += s.length() * covered(s, own);
      const ImageView<const std::uint8_t> view = opencv::view<std::uint8_t>(image);
      ++long_ones;
      followed += tracker.track(*edges, view, profile_of(view, s), s, LineTrackingOptions{}).valid;
    }
    std::cout << image.size() << ": " << own.size() << " own segments, " << own_by_lsd_px / own_px
              << " of their length by LSD; " << lsd.size() << " of LSD, " << lsd_by_own_px / lsd_px
              << " of their length here; followed " << followed << " of " << long_ones << '\n';
    CAPTURE(own.size(), lsd.size(), own_by_lsd_px / own_px, lsd_by_own_px / lsd_px, followed, long_ones);
    CHECK(own_by_lsd_px > 0.6f * own_px);
    CHECK(lsd_by_own_px > 0.6f * lsd_px);
    CHECK(followed > 0.8 * long_ones);
  }
}
