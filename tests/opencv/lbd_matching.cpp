// Two views of a rendered room: matches are checked by the depth image, which has the true position of an edge.
#include "plumbline/opencv/lbd_matching.hpp"

#include <iostream>
#include <memory>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/opencv/lsd_detector.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;
using namespace plumbline::opencv;

namespace {

constexpr int width = 640, height = 480;
const Pinhole<double> camera{500, 500, 319.5, 239.5, {}};

struct ViewOfRoom {
  SE3<double> T_world_cam;
  cv::Mat gray;
  testing::Image<float> depth{width, height};
};

ViewOfRoom view_at(testing::Renderer& renderer, double t) {
  ViewOfRoom out;
  out.T_world_cam = testing::Trajectory::for_scene("room")->at(t).T_world_body * testing::simulated_T_body_camera();
  testing::Image<float> gray(width, height);
  renderer.render(out.T_world_cam, gray.view(), out.depth.view());
  cv::Mat sharp(height, width, CV_32F, const_cast<float*>(gray.pixels().data()));
  cv::GaussianBlur(sharp, sharp, {5, 5}, 0.6);
  sharp.convertTo(out.gray, CV_8U);
  out.gray = testing::with_noise(out.gray, 1.5, static_cast<std::uint64_t>(100 * t));
  return out;
}

using Segments = FixedVector<LineSegment, 300>;

template <class Detector>
Segments detect(const cv::Mat& gray) {
  static const auto edges = std::make_unique<EdgeMap<width * height>>();
  static const auto detector = std::make_unique<Detector>();
  Segments out;
  REQUIRE(edges->compute(view<std::uint8_t>(gray), LineDetectorOptions{}.min_gradient));
  detector->detect(view<std::uint8_t>(gray), *edges, LineDetectorOptions{}, out);
  return out;
}

/// Part of segment `a` of one view that lies on segment `b` of another; an edge belongs to the nearest surface at it.
double share_on(const ViewOfRoom& from, const LineSegment& a, const ViewOfRoom& to, const LineSegment& b) {
  constexpr int samples = 20;
  const ImageView<const float> depth = from.depth.view();
  int hits = 0;
  for (int k = 0; k < samples; ++k) {
    const Vec<float, 2> at = a.start + (static_cast<float>(k) + 0.5f) / samples * (a.end - a.start);
    float z = 1e3f;
    for (const float j : {-2.0f, 0.0f, 2.0f}) {
      const Vec<float, 2> uv = at + j * a.normal();
      if (!depth.contains(uv.x(), uv.y(), 1.0f)) continue;
      const float here = depth(static_cast<int>(uv.x() + 0.5f), static_cast<int>(uv.y() + 0.5f));
      if (here > 0) z = std::min(z, here);
    }
    const Vec<double, 3> bearing = camera.unproject(Vec<double, 2>(at.cast<double>())).bearing;
    const Vec<double, 3> p_world = from.T_world_cam * Vec<double, 3>(z / bearing.z() * bearing);
    const auto seen = camera.project(to.T_world_cam.inverse() * p_world);
    if (!seen.valid) continue;
    const Vec<float, 2> uv = seen.uv.cast<float>();
    const float along = b.direction().dot(uv - b.start);
    hits += std::abs(b.distance(uv)) < 2.5f && along > -5 && along < b.length() + 5;
  }
  return static_cast<double>(hits) / samples;
}

/// Parts of one edge in both views, though each may show a part of it that the other lacks.
bool is_right(const ViewOfRoom& first, const LineSegment& a, const ViewOfRoom& second, const LineSegment& b) {
  return a.direction().dot(b.direction()) > 0.8f &&
         std::max(share_on(first, a, second, b), share_on(second, b, first, a)) > 0.5;
}

}  // namespace

TEMPLATE_TEST_CASE("lbd_matching: two views of a room", "", LineSegmentDetector<>, LsdDetector<>) {
  testing::Renderer renderer(*testing::make_scene("room"), camera, width, height, 2);
  for (const double t : {2.0, 5.0, 8.0, 11.0}) {
    const ViewOfRoom first = view_at(renderer, t), second = view_at(renderer, t + 0.25);
    const Segments a = detect<TestType>(first.gray), b = detect<TestType>(second.gray);
    const std::vector<LineMatch> matches =
        match_lines_lbd(view<std::uint8_t>(first.gray), a, view<std::uint8_t>(second.gray), b);
    int right = 0, seen_twice = 0;
    for (const LineMatch& match : matches) right += is_right(first, a[match.first], second, b[match.second]);
    for (const LineSegment& s : a) {
      seen_twice +=
          std::any_of(b.begin(), b.end(), [&](const LineSegment& o) { return is_right(first, s, second, o); });
    }
    const SE3<double> T = first.T_world_cam.inverse() * second.T_world_cam;
    std::cout << a.size() << " and " << b.size() << " segments after " << T.p().norm() << " m, "
              << T.rotation().log().norm() * 57.3 << " deg: " << right << " of " << matches.size()
              << " matches are right, " << seen_twice << " possible\n";
    CAPTURE(t, a.size(), b.size(), matches.size(), right, seen_twice);
    REQUIRE(right > 0.9 * static_cast<double>(matches.size()));
    REQUIRE(right > 0.5 * seen_twice);
  }
}

TEST_CASE("lbd_matching: a turned image has nearly the same descriptors, the other side of an edge has not") {
  const cv::Mat image = testing::textured_image();
  const testing::AffineMotion motion = testing::about_center(image, 20, 1, {5, -3});
  const cv::Mat turned = testing::warped(image, motion, 0.9, 8);
  const Segments before = detect<LineSegmentDetector<>>(image);
  Segments after, flipped;
  for (const LineSegment& s : before) {
    after.push_back({motion(s.start), motion(s.end), s.gradient});
    flipped.push_back({motion(s.end), motion(s.start), s.gradient});
  }
  const std::vector<LineDescriptor> a = lbd_descriptors(view<std::uint8_t>(image), before);
  const std::vector<LineDescriptor> b = lbd_descriptors(view<std::uint8_t>(turned), after);
  const std::vector<LineDescriptor> c = lbd_descriptors(view<std::uint8_t>(turned), flipped);
  std::vector<double> same, other;
  const ImageView<const std::uint8_t> seen = view<std::uint8_t>(turned);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!seen.contains(after[i].start.x(), after[i].start.y(), 35.0f) ||
        !seen.contains(after[i].end.x(), after[i].end.y(), 35.0f)) {
      continue;
    }
    same.push_back(hamming_distance(a[i], b[i]));
    other.push_back(hamming_distance(a[i], c[i]));
  }
  CAPTURE(same.size(), testing::quantile(same, 0.5), testing::quantile(same, 0.9), testing::quantile(other, 0.1));
  std::cout << same.size() << " turned: " << testing::quantile(same, 0.5) << ", " << testing::quantile(same, 0.9)
            << "; other side " << testing::quantile(other, 0.1) << '\n';
  REQUIRE(same.size() > 30);
  REQUIRE(testing::quantile(same, 0.9) < 30);
  REQUIRE(testing::quantile(other, 0.1) > 60);
}

TEST_CASE("lbd_matching: no segments, and segments that reach out of the image") {
  const cv::Mat image = testing::textured_image();
  REQUIRE(lbd_descriptors(view<std::uint8_t>(image), {}).empty());
  const std::vector<LineSegment> outside{{{-50, 10}, {40, 10}, 5}, {{600, 400}, {900, 700}, 5}, {{5, 5}, {6, 5}, 5}};
  REQUIRE(lbd_descriptors(view<std::uint8_t>(image), outside).size() == 3);
}
