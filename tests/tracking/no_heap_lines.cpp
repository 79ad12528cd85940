// Detecting, tracking, measuring and triangulating lines allocates nothing.
#include "allocation_counter.hpp"

#include <array>
#include <memory>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/geometry/line_triangulation.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/sensor/line_depth_measurement.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"
#include "tracking/drawn_edges.hpp"

using namespace plumbline;

TEST_CASE("no heap: detect, track, measure depth, triangulate, linearize") {
  const auto shape = testing::Quadrilateral::rectangle(Vec<float, 2>(160, 120), 150, 90, 0.3f);
  cv::Mat drawn(240, 320, CV_32F, cv::Scalar(60)), image;
  testing::draw(drawn, shape, 80);
  drawn.convertTo(image, CV_8U);
  const cv::Mat depth(240, 320, CV_16U, cv::Scalar(2000));
  const ImageView<const std::uint8_t> view = opencv::view<std::uint8_t>(image);
  const auto edges = std::make_unique<EdgeMap<320 * 240>>();
  const auto detector = std::make_unique<LineSegmentDetector<>>();
  const Pinhole<float> camera{268, 268, 159.5f, 119.5f, {}};
  const SE3<float> I, T_cj_ca(SO3<float>(), {0, 0.2f, 0});
  const RelativeView<float> relative(I, T_cj_ca.inverse(), I);

  FixedVector<LineSegment, 50> segments;
  LineTracker tracker;
  bool ok = false;
  int tracked = 0, measured = 0, triangulated = 0, linearized = 0;
  const long allocations = test::allocations_of([&] {
    ok = edges->compute(view, 1.6f);
    detector->detect(*edges, LineDetectorOptions{}, segments);
    for (const LineSegment& s : segments) {
      tracked += tracker.track(*edges, view, profile_of(view, s), s, LineTrackingOptions{}).valid;
      const auto found =
          measure_line_depth(camera, DepthSensor<float>{}, opencv::view<std::uint16_t>(depth), s.start, s.end);
      measured += found.valid;
      const auto seen = observe_line<Pinhole<float>>(camera, s.start, s.end);
      const Vec<float, 3>&b_s = seen.reprojection.bearing_start, &b_e = seen.reprojection.bearing_end;
      const Vec<float, 3> m_s = b_s / b_s.z(), m_e = b_e / b_e.z();
      const Line3<float> line = line_from_depth(m_s, m_e, found.inverse_depth);
      linearized += AnchoredLineReprojection<float>{seen.reprojection}.linearize(relative, line).valid;
      const std::array<LineTriangulationView<float>, 2> views{LineTriangulationView<float>{I, b_s, b_e, 1e-3f},
                                                              {T_cj_ca, (T_cj_ca * Vec<float, 3>(2 * m_s)).normalized(),
                                                               (T_cj_ca * Vec<float, 3>(2 * m_e)).normalized(), 1e-3f}};
      triangulated += triangulate_line(std::span<const LineTriangulationView<float>>(views)).valid;
    }
  });
  REQUIRE(allocations == 0);
  REQUIRE(test::allocations_of([] { REQUIRE(std::make_unique<int>(3)); }) > 0);  // the watch sees what it should
  REQUIRE(ok);
  REQUIRE(segments.size() == 4);
  REQUIRE(tracked == 4);
  REQUIRE(measured == 4);
  REQUIRE(linearized == 4);
  REQUIRE(triangulated >= 2);
}
