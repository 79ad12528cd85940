#include "plumbline/tracking/line_segment_detector.hpp"

#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Vec2f;

namespace {

using Segments = FixedVector<LineSegment, 300>;
using Edges = EdgeMap<1300 * 480>;

Segments detect(const cv::Mat& image, const LineDetectorOptions& options = {}) {
  static const auto edges = std::make_unique<Edges>();
  static const auto detector = std::make_unique<LineSegmentDetector<>>();
  Segments out;
  REQUIRE(edges->compute(opencv::view<std::uint8_t>(image), options.min_gradient));
  detector->detect(*edges, options, out);
  return out;
}

struct Errors {
  double angle_deg = 0, distance_px = 0, end_px = 0;
  int found = 0, edges = 0, others = 0;
};

/// Rectangles at many angles: each edge must be found once, nothing else.
Errors errors_of_rectangles(float contrast, double noise) {
  Errors errors;
  for (int i = 0; i < 24; ++i) {
    const float angle = 0.2731f * static_cast<float>(i), shift = 0.37f * static_cast<float>(i);
    cv::Mat drawn(240, 320, CV_32F, cv::Scalar(90)), image;
    const auto shape = testing::Quadrilateral::rectangle(Vec2f(160 + shift, 118 - shift), 120, 80, angle);
    testing::draw(drawn, shape, contrast);
    cv::GaussianBlur(drawn, drawn, {5, 5}, 0.6);
    drawn.convertTo(image, CV_8U);
    image = testing::with_noise(image, noise, static_cast<std::uint64_t>(i) + 1);
    const Segments segments = detect(image);
    for (std::size_t k = 0; k < 4; ++k) {
      const LineSegment truth = shape.edge(k);
      int matches = 0;
      for (const LineSegment& s : segments) {
        const double off = std::max(std::abs(truth.distance(s.start)), std::abs(truth.distance(s.end)));
        if (testing::angle_between(s, truth) > 0.1f || off > 3) continue;
        ++matches;
        errors.angle_deg = std::max(errors.angle_deg, testing::angle_between(s, truth) * 57.3);
        errors.distance_px = std::max(errors.distance_px, double(std::abs(truth.distance(s.center()))));
        errors.end_px =
            std::max({errors.end_px, double((s.start - truth.start).norm()), double((s.end - truth.end).norm())});
        REQUIRE(s.gradient > 0);
      }
      errors.found += matches > 0;
      errors.others += matches - 1;
      ++errors.edges;
    }
    errors.others += static_cast<int>(segments.size()) - 4;
  }
  return errors;
}

}  // namespace

TEST_CASE("line_segment_detector: edges of known geometry") {
  const Errors exact = errors_of_rectangles(80, 0);
  CAPTURE(exact.angle_deg, exact.distance_px, exact.end_px, exact.found, exact.others);
  REQUIRE(exact.found == exact.edges);
  REQUIRE(exact.others == 0);
  REQUIRE(exact.angle_deg < 0.15);
  REQUIRE(exact.distance_px < 0.05);
  REQUIRE(exact.end_px < 3);
  const Errors noisy = errors_of_rectangles(60, 4);
  CAPTURE(noisy.angle_deg, noisy.distance_px, noisy.end_px, noisy.found, noisy.others);
  REQUIRE(noisy.found == noisy.edges);
  REQUIRE(noisy.others == 0);
  REQUIRE(noisy.angle_deg < 0.25);
  REQUIRE(noisy.distance_px < 0.15);
  const Errors faint = errors_of_rectangles(7, 1.2);  // nearly white walls
  CAPTURE(faint.angle_deg, faint.distance_px, faint.end_px, faint.found, faint.others);
  REQUIRE(faint.found > 0.9 * faint.edges);
  REQUIRE(faint.angle_deg < 1.2);
  REQUIRE(faint.distance_px < 0.4);
}

TEST_CASE("line_segment_detector: nothing in noise, flat or blurred") {
  for (const double sigma : {0.0, 1.0, 2.0, 4.0, 8.0}) {
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      cv::Mat image = testing::with_noise(cv::Mat(480, 752, CV_8U, cv::Scalar(128)), sigma, seed);
      REQUIRE(detect(image).empty());
      cv::GaussianBlur(image, image, {3, 3}, 0.8);
      REQUIRE(detect(image).empty());
    }
  }
}

TEST_CASE("line_segment_detector: circles give only chords as short as the tolerance allows") {
  cv::Mat image(300, 300, CV_8U, cv::Scalar(50));
  cv::circle(image, {150, 150}, 60, cv::Scalar(200), cv::FILLED, cv::LINE_AA);
  for (const LineSegment& s : detect(image)) REQUIRE(s.length() < 40);  // sagitta of 1.2 + 1.2 px: 34 px
}

TEST_CASE("line_segment_detector: the edges of a recorded image are found again after a motion", "[data]") {
  if (skip_without(testing::recordings)) return;
  for (const cv::Mat& recorded : testing::recorded_images()) {
    const Segments before = detect(recorded);
    const testing::AffineMotion motion = testing::about_center(recorded, 4, 1.02f, {3.3f, -2.2f});
    const cv::Mat moved = testing::with_noise(testing::warped(recorded, motion, 0.95, 4), 2.0, 5);
    const Segments after = detect(moved);
    int expected = 0, found = 0;
    for (const LineSegment& s : before) {
      const LineSegment truth{motion(s.start), motion(s.end), 0};
      const ImageView<const std::uint8_t> view = opencv::view<std::uint8_t>(moved);
      if (s.length() < 40 || !view.contains(truth.start.x(), truth.start.y(), 8.0f) ||
          !view.contains(truth.end.x(), truth.end.y(), 8.0f)) {
        continue;
      }
      ++expected;
      for (const LineSegment& t : after) {
        const float from = truth.direction().dot(t.start - truth.start),
                    to = truth.direction().dot(t.end - truth.start);
        const float overlap = std::min(to, truth.length()) - std::max(from, 0.0f);
        if (testing::angle_between(t, truth) < 0.03f && overlap > 0.6f * truth.length() &&
            std::abs(truth.distance(t.center())) < 1.0f) {
          ++found;
          break;
        }
      }
    }
    CAPTURE(expected, found, before.size());
    REQUIRE(found >= 0.65 * expected);
  }
}

TEST_CASE("line_segment_detector: the same every time, longest first, the longest when there is little room") {
  cv::Mat drawn(240, 320, CV_32F, cv::Scalar(90)), image;
  for (int i = 0; i < 5; ++i) {
    const float size = 20 + 8 * static_cast<float>(i), x = 30 + 62 * static_cast<float>(i);
    testing::draw(drawn, testing::Quadrilateral::rectangle(Vec2f(x, 120), size, 2 * size, 0.1f), 70);
  }
  drawn.convertTo(image, CV_8U);
  const Segments all = detect(image);
  REQUIRE(all.size() > 12);
  for (std::size_t i = 1; i < all.size(); ++i) REQUIRE(all[i].length() <= all[i - 1].length());
  const Segments again = detect(image);
  REQUIRE(again.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) REQUIRE(all[i].start == again[i].start);
  const auto edges = std::make_unique<Edges>();
  REQUIRE(edges->compute(opencv::view<std::uint8_t>(image), LineDetectorOptions{}.min_gradient));
  const auto small = std::make_unique<LineSegmentDetector<12>>();
  FixedVector<LineSegment, 6> few;
  small->detect(*edges, LineDetectorOptions{}, few);
  REQUIRE(few.size() == 6);
  for (std::size_t i = 0; i < few.size(); ++i) REQUIRE(few[i].length() == Approx(all[i].length()));
  LineDetectorOptions options;
  options.min_length_px = 60;
  const Segments some = detect(image, options);
  REQUIRE(!some.empty());
  REQUIRE(some.size() < all.size());
  for (const LineSegment& s : some) REQUIRE(s.length() >= 60);
}

TEST_CASE("line_segment_detector: an image that the map refused gives nothing") {
  const auto edges = std::make_unique<EdgeMap<100 * 100>>();
  const auto detector = std::make_unique<LineSegmentDetector<>>();
  REQUIRE_FALSE(edges->compute(opencv::view<std::uint8_t>(testing::textured_image()), 2));
  Segments out;
  out.push_back({});
  detector->detect(*edges, LineDetectorOptions{}, out);
  REQUIRE(out.empty());
}
