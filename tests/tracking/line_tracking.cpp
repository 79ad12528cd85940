#include "plumbline/tracking/line_tracking.hpp"

#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"
#include "tracking/drawn_edges.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using plumbline::testing::Quadrilateral;
using plumbline::testing::Vec2f;

namespace {

using View = ImageView<const std::uint8_t>;
using Segments = FixedVector<LineSegment, 300>;

/// An image with its edges.
struct Frame {
  cv::Mat image;
  std::unique_ptr<EdgeMap<1300 * 480>> edges = std::make_unique<EdgeMap<1300 * 480>>();

  explicit Frame(const cv::Mat& m) : image(m) { REQUIRE(edges->compute(view(), LineDetectorOptions{}.min_gradient)); }
  View view() const { return opencv::view<std::uint8_t>(image); }
  Segments segments() {
    static const auto detector = std::make_unique<LineSegmentDetector<>>();
    Segments out;
    detector->detect(*edges, LineDetectorOptions{}, out);
    return out;
  }
};

TrackedLine track(const Frame& previous, const Frame& current, const LineSegment& segment, LineSegment guess,
                  const LineTrackingOptions& options = {}) {
  LineTracker tracker;
  guess.gradient = segment.gradient;
  return tracker.track(*current.edges, current.view(), profile_of(previous.view(), segment), guess, options);
}

using Shapes = std::vector<std::pair<Quadrilateral, float>>;

cv::Mat drawing(const Shapes& shapes, std::uint64_t seed, const Shapes& covers = {}) {
  cv::Mat drawn(240, 320, CV_32F, cv::Scalar(90)), image;
  for (const auto& [shape, contrast] : shapes) testing::draw(drawn, shape, contrast);
  for (const auto& [shape, intensity] : covers) testing::cover(drawn, shape, intensity);
  cv::GaussianBlur(drawn, drawn, {5, 5}, 0.6);
  drawn.convertTo(image, CV_8U);
  return testing::with_noise(image, 2, seed);
}

LineSegment moved(const LineSegment& s, const testing::AffineMotion& motion) {
  return {motion(s.start), motion(s.end), s.gradient};
}

float line_error(const LineSegment& s, const LineSegment& truth) {
  return std::max(std::abs(truth.distance(s.start)), std::abs(truth.distance(s.end)));
}

}  // namespace

TEST_CASE("line_tracking: known motions, without a prediction and with one that is wrong") {
  const Quadrilateral shape = Quadrilateral::rectangle(Vec2f(160, 120), 110, 70, 0.3f);
  const Frame before(drawing({{shape, 60}}, 1));
  for (const auto& [degrees, shift, with_guess] : {std::tuple(0.0f, Vec2f(0, 0), false),
                                                   {3.0f, Vec2f(6, -5), false},
                                                   {-5.0f, Vec2f(-8, 2), false},
                                                   {20.0f, Vec2f(35, -20), true},
                                                   {-35.0f, Vec2f(-30, 25), true}}) {
    const testing::AffineMotion motion = testing::about_center(before.image, degrees, 1.03f, shift);
    Quadrilateral shape_after = shape;
    for (Vec2f& corner : shape_after.corner) corner = motion(corner);
    const Frame after(drawing({{shape_after, 55}}, 2));
    for (std::size_t k = 0; k < 4; ++k) {
      LineSegment segment = shape.edge(k);
      segment.gradient = 20;
      LineSegment guess = segment;
      if (with_guess) {  // 5 px and 3 degrees off
        guess = moved(segment, testing::about_center(before.image, degrees + 3, 1.0f, shift + Vec2f(3, -4)));
      }
      const TrackedLine tracked = track(before, after, segment, guess);
      CAPTURE(degrees, k, tracked.support, tracked.rms_px, tracked.segment.length());
      REQUIRE(tracked.valid);
      const LineSegment truth = shape_after.edge(k);
      REQUIRE(line_error(tracked.segment, truth) < 0.25f);
      REQUIRE(testing::angle_between(tracked.segment, truth) < 0.006f);
      REQUIRE((tracked.segment.start - truth.start).norm() < 6);
      REQUIRE((tracked.segment.end - truth.end).norm() < 6);
      REQUIRE(tracked.rms_px < 0.35f);
      REQUIRE(tracked.support > 0.8f);
    }
  }
}

TEST_CASE("line_tracking: of parallel edges the predicted one, never one of the other polarity") {
  // bars of 9 px every 18 px
  Shapes bars, shifted;
  for (int i = -4; i <= 4; ++i) {
    const Vec2f center(160 + 18 * static_cast<float>(i), 120);
    bars.push_back({Quadrilateral::rectangle(center, 9, 150, 0), 60});
    shifted.push_back({Quadrilateral::rectangle(center + Vec2f(5, 3), 9, 150, 0), 60});
  }
  const Frame before(drawing(bars, 1)), after(drawing(shifted, 2));
  for (const std::size_t bar : {2u, 4u, 6u}) {
    for (const std::size_t k : {1u, 3u}) {
      LineSegment segment = bars[bar].first.edge(k);
      segment.gradient = 20;
      const TrackedLine tracked = track(before, after, segment, segment);
      REQUIRE(tracked.valid);
      REQUIRE(line_error(tracked.segment, shifted[bar].first.edge(k)) < 0.3f);
    }
  }
  // one edge alone, with the polarity of the other side
  const Quadrilateral wide = Quadrilateral::rectangle(Vec2f(160, 120), 100, 150, 0);
  const Frame bright(drawing({{wide, 60}}, 1)), dark(drawing({{wide, -60}}, 1));
  LineSegment edge = wide.edge(1);
  edge.gradient = 20;
  REQUIRE(track(bright, bright, edge, edge).valid);
  REQUIRE_FALSE(track(bright, dark, edge, edge).valid);
}

TEST_CASE("line_tracking: an occlusion cuts the segment, or splits it and the longer part is tracked; then it grows") {
  const Quadrilateral shape = Quadrilateral::rectangle(Vec2f(160, 120), 200, 90, 0);
  const Quadrilateral at_end = Quadrilateral::rectangle(Vec2f(240, 75), 60, 60, 0.4f);
  const Quadrilateral inside = Quadrilateral::rectangle(Vec2f(190, 75), 40, 50, 0.4f);
  const Frame free(drawing({{shape, 60}}, 1)), cut(drawing({{shape, 60}}, 2, {{at_end, 20}})),
      split(drawing({{shape, 60}}, 3, {{inside, 20}}));
  LineSegment segment = shape.edge(0);  // x from 60 to 260 at y = 75
  segment.gradient = 20;
  const TrackedLine with_cut = track(free, cut, segment, segment);
  REQUIRE(with_cut.valid);
  REQUIRE(line_error(with_cut.segment, segment) < 0.3f);
  REQUIRE(with_cut.segment.end.x() < 214);
  REQUIRE(with_cut.segment.end.x() > 190);
  const TrackedLine with_split = track(free, split, segment, segment);
  REQUIRE(with_split.valid);
  REQUIRE(with_split.segment.start.x() < 64);
  REQUIRE(with_split.segment.end.x() < 178);
  REQUIRE(with_split.segment.end.x() > 155);
  TrackedLine grown = with_cut;
  for (int i = 0; i < 5; ++i) {
    const float before = grown.segment.end.x();
    grown = track(free, free, grown.segment, grown.segment);
    REQUIRE(grown.valid);
    REQUIRE(grown.segment.end.x() - before < LineTrackingOptions{}.max_growth_px + 4);
  }
  REQUIRE(grown.segment.end.x() > 256);
  REQUIRE(grown.segment.end.x() < 263);
}

TEST_CASE("line_tracking: a long edge is sampled coarsely and still cut and split where it is hidden") {
  const Quadrilateral shape = Quadrilateral::rectangle(Vec2f(320, 240), 560, 200, 0.1f);
  cv::Mat drawn(480, 640, CV_32F, cv::Scalar(90)), hidden;
  testing::draw(drawn, shape, 60);
  hidden = drawn.clone();
  testing::cover(hidden, Quadrilateral::rectangle(shape.edge(0).center() + Vec2f(60, 0), 110, 60, 0.4f), 20);
  drawn.convertTo(drawn, CV_8U);
  hidden.convertTo(hidden, CV_8U);
  const Frame before(testing::with_noise(drawn, 2, 1)), after(testing::with_noise(drawn, 2, 2)),
      split(testing::with_noise(hidden, 2, 3));
  LineSegment segment = shape.edge(0);
  segment.gradient = 20;
  LineSegment guess{segment.start + Vec2f(3, 4), segment.end + Vec2f(-2, -3), 20};
  const TrackedLine whole = track(before, after, segment, guess);
  REQUIRE(whole.valid);
  REQUIRE(line_error(whole.segment, segment) < 0.2f);
  REQUIRE(whole.segment.length() == Approx(560).margin(8));
  const TrackedLine part = track(before, split, segment, guess);
  REQUIRE(part.valid);
  REQUIRE(line_error(part.segment, segment) < 0.3f);
  REQUIRE(part.segment.length() == Approx(280).margin(15));
}

TEST_CASE("line_tracking: an edge that is gone, out of the image or not a number") {
  const Quadrilateral shape = Quadrilateral::rectangle(Vec2f(160, 120), 110, 70, 0.3f);
  const Frame before(drawing({{shape, 60}}, 1)), empty(drawing({}, 2));
  LineSegment segment = shape.edge(0);
  segment.gradient = 20;
  REQUIRE_FALSE(track(before, empty, segment, segment).valid);
  REQUIRE_FALSE(track(before, before, segment, {segment.start - Vec2f(0, 500), segment.end - Vec2f(0, 500), 20}).valid);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE_FALSE(track(before, before, segment, {Vec2f(nan, 0), segment.end, 20}).valid);
  REQUIRE_FALSE(track(before, before, segment, {segment.start, segment.start, 20}).valid);
  // partly out of the image: what is inside is tracked
  const Quadrilateral beyond = Quadrilateral::rectangle(Vec2f(290, 120), 110, 70, 0.0f);
  const Frame at_border(drawing({{beyond, 60}}, 1));
  LineSegment edge = beyond.edge(0);
  edge.gradient = 20;
  const TrackedLine tracked = track(at_border, at_border, edge, edge);
  REQUIRE(tracked.valid);
  REQUIRE(tracked.segment.end.x() < 318);
  REQUIRE(tracked.segment.end.x() > 308);
}

TEST_CASE("line_tracking: overlapping tracks on one edge are duplicates of the first") {
  FixedVector<LineSegment, 8> tracks;
  tracks.push_back({Vec2f(0, 0), Vec2f(60, 0), 10});
  tracks.push_back({Vec2f(40, 0.4f), Vec2f(100, 0.6f), 10});  // of 0
  tracks.push_back({Vec2f(0, 10), Vec2f(60, 10), 10});        // another edge
  tracks.push_back({Vec2f(90, 0.5f), Vec2f(140, 0.5f), 10});  // overlaps 1, which goes
  tracks.push_back({Vec2f(60, 10), Vec2f(0, 10), 10});        // the other polarity
  std::array<bool, 8> duplicate;
  mark_duplicates(tracks, duplicate);
  REQUIRE_FALSE(duplicate[0]);
  REQUIRE(duplicate[1]);
  REQUIRE_FALSE(duplicate[2]);
  REQUIRE_FALSE(duplicate[3]);
  REQUIRE_FALSE(duplicate[4]);
}

TEST_CASE("line_tracking: recorded images moved by tens of pixels, predicted within some pixels", "[data]") {
  if (skip_without(PLUMBLINE_TEST_DATA)) return;
  for (const cv::Mat& recorded : testing::recorded_images()) {
    Frame before(recorded);
    const testing::AffineMotion motion = testing::about_center(recorded, 12, 1.03f, {32, -21});
    const testing::AffineMotion predicted = testing::about_center(recorded, 11, 1.0f, {28, -18});
    const Frame after(testing::with_noise(testing::warped(recorded, motion, 0.92, 5), 2.0, 5));
    int expected = 0, found = 0;
    std::vector<double> errors;
    for (const LineSegment& s : before.segments()) {
      const LineSegment truth = moved(s, motion);
      if (s.length() < 30 || !after.view().contains(truth.start.x(), truth.start.y(), 8.0f) ||
          !after.view().contains(truth.end.x(), truth.end.y(), 8.0f)) {
        continue;
      }
      ++expected;
      const TrackedLine tracked = track(before, after, s, moved(s, predicted));
      if (!tracked.valid) continue;
      ++found;
      errors.push_back(double(line_error(tracked.segment, truth)));
    }
    std::cout << "turned: " << found << " of " << expected << ", median error " << testing::quantile(errors, 0.5)
              << " px, 90 % " << testing::quantile(errors, 0.9) << " px\n";
    REQUIRE(found > 0.7 * expected);
    REQUIRE(testing::quantile(errors, 0.5) < 0.6);
  }
}

TEST_CASE("line_tracking: a rendered sequence, each frame from the one before") {
  const test::SimulatedRgbd simulated(12);
  const auto frame = [&](std::size_t i) {
    const auto& pixels = simulated.frames[i].gray;
    return cv::Mat(240, 320, CV_8U, const_cast<std::uint8_t*>(pixels.view().data)).clone();
  };
  const auto depth_at = [&](const Vec2f& uv) {
    return simulated.frames[0].depth.view()(int(std::lround(uv.x())), int(std::lround(uv.y()))) / 1000.0;
  };
  Frame first(frame(0));
  struct Track {
    LineSegment segment;
    Line3<double> line;  ///< world
  };
  std::vector<Track> tracks;
  for (const LineSegment& s : first.segments()) {
    if (s.length() < 30) continue;
    // edges within one surface: the same depth on both sides, and affine inverse depth along it
    const Vec2f a = s.start + 3 * s.direction(), b = s.end - 3 * s.direction(), n = 3 * s.normal();
    bool flat = true;
    for (const Vec2f& at : {a, b, s.center()}) {
      const double z0 = depth_at(at - n), z1 = depth_at(at + n), z = depth_at(at);
      flat = flat && z0 > 0 && z1 > 0 && z > 0 && std::abs(z0 - z1) < 0.05 * z && std::abs(z0 - z) < 0.05 * z;
    }
    if (!flat) continue;
    const auto point = [&](const Vec2f& uv) -> Vec<double, 3> {
      const Vec<double, 3> ray = simulated.camera.unproject(uv.cast<double>()).bearing;
      return simulated.T_world_cam[0] * Vec<double, 3>(ray / ray.z() * depth_at(uv));
    };
    tracks.push_back({s, Line3<double>::through(point(a), point(b))});
  }
  const std::size_t started = tracks.size();
  REQUIRE(started > 10);
  std::vector<double> errors;
  int lost = 0;
  Frame previous(frame(0));
  for (std::size_t i = 1; i < 12; ++i) {
    Frame current(frame(i));
    const SO3<double> R = (simulated.T_world_cam[i].inverse() * simulated.T_world_cam[i - 1]).rotation();
    const auto turned = [&](const Vec2f& uv) -> Vec2f {  // what a gyroscope predicts
      const Vec<double, 3> bearing = simulated.camera.unproject(uv.cast<double>()).bearing;
      return simulated.camera.project(R * bearing).uv.cast<float>();
    };
    for (std::size_t k = tracks.size(); k-- > 0;) {
      const LineSegment& s = tracks[k].segment;
      const LineSegment guess{turned(s.start), turned(s.end), 0};
      const TrackedLine tracked = track(previous, current, s, guess);
      if (!tracked.valid) {
        lost += current.view().contains(guess.start.x(), guess.start.y(), 4.0f) &&
                current.view().contains(guess.end.x(), guess.end.y(), 4.0f);
        tracks.erase(tracks.begin() + std::ptrdiff_t(k));
        continue;
      }
      tracks[k].segment = tracked.segment;
      const Plucker<double> line = simulated.T_world_cam[i].inverse() * tracks[k].line.plucker();
      for (const Vec2f& uv : {tracked.segment.start, tracked.segment.end}) {
        const Vec<double, 3> m((uv.x() - simulated.camera.cx) / simulated.camera.fx,
                               (uv.y() - simulated.camera.cy) / simulated.camera.fy, 1);
        errors.push_back(simulated.camera.fx * std::abs(line.n.dot(m)) / line.n.head<2>().norm());
      }
    }
    previous = std::move(current);
  }
  std::cout << "rendered: of " << started << ", " << tracks.size() << " left after 11 frames, " << lost
            << " lost within the image; median error " << testing::quantile(errors, 0.5) << " px, 90 % "
            << testing::quantile(errors, 0.9) << " px\n";
  REQUIRE(lost < 0.25 * double(started));
  REQUIRE(testing::quantile(errors, 0.5) < 0.4);
}

TEST_CASE("line_tracking: recorded pairs, there and back", "[data]") {
  const std::filesystem::path folder = std::filesystem::path(PLUMBLINE_TEST_DATA) / "euroc_mh01_flight/mav0/cam0/data";
  if (skip_without(folder)) return;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  int tracked = 0, returned = 0, expected = 0;
  for (std::size_t i = 20; i + 1 < files.size(); i += 70) {
    Frame before(cv::imread(files[i], cv::IMREAD_GRAYSCALE));
    const Frame after(cv::imread(files[i + 1], cv::IMREAD_GRAYSCALE));
    for (const LineSegment& s : before.segments()) {
      if (s.length() < 40) continue;
      ++expected;
      const TrackedLine there = track(before, after, s, s);
      if (!there.valid) continue;
      ++tracked;
      const TrackedLine back = track(after, before, there.segment, there.segment);
      returned += back.valid && line_error(back.segment, s) < 1.5f;
    }
  }
  std::cout << "recorded: " << tracked << " of " << expected << " tracked, " << returned << " of them back\n";
  REQUIRE(tracked > 0.6 * expected);
  REQUIRE(returned > 0.85 * tracked);
}
