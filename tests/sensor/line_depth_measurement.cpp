#include "plumbline/sensor/line_depth_measurement.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"

using namespace plumbline;

TEST_CASE("line_depth_measurement: the lines of rendered frames lie on surfaces, mixed with nothing behind them") {
  const test::SimulatedRgbd simulated(6, 3.0, 5);
  const testing::Scene scene = *testing::make_scene("room");
  const auto edges = std::make_unique<EdgeMap<320 * 240>>();
  const auto detector = std::make_unique<LineSegmentDetector<>>();
  DepthSensor<double> sensor;
  std::vector<double> distances, in_sigmas;
  int segments_seen = 0;
  for (std::size_t i = 0; i < simulated.frames.size(); ++i) {
    FixedVector<LineSegment, 100> segments;
    REQUIRE(edges->compute(simulated.frames[i].gray.view(), LineDetectorOptions{}.min_gradient));
    detector->detect(*edges, LineDetectorOptions{}, segments);
    for (const LineSegment& s : segments) {
      ++segments_seen;
      const LineDepth<double> depth =
          measure_line_depth(simulated.camera, sensor, simulated.frames[i].depth.view(), s.start, s.end);
      if (!depth.valid) continue;
      for (int end = 0; end < 2; ++end) {
        const Vec<float, 2> uv = end == 0 ? s.start : s.end;
        const Vec<double, 3> bearing = simulated.camera.unproject(uv.cast<double>()).bearing;
        const Vec<double, 3> p_cam = bearing / bearing.z() / depth.inverse_depth[end];
        const double distance = scene.distance(simulated.T_world_cam[i] * p_cam);
        distances.push_back(distance / p_cam.z());
        in_sigmas.push_back(distance / p_cam.z() * depth.inverse_depth[end] / std::sqrt(depth.covariance(end, end)));
      }
    }
  }
  std::sort(distances.begin(), distances.end());
  std::sort(in_sigmas.begin(), in_sigmas.end());
  REQUIRE(!distances.empty());
  std::cout << distances.size() / 2 << " of " << segments_seen
            << " lines with depth; distance to the next surface: median " << 100 * distances[distances.size() / 2]
            << " % of the depth, 90 % " << 100 * distances[distances.size() * 9 / 10] << " %; in sigmas 90 % "
            << in_sigmas[in_sigmas.size() * 9 / 10] << '\n';
  REQUIRE(double(distances.size()) > 2 * 0.6 * segments_seen);
  REQUIRE(distances[distances.size() / 2] < 0.005);
  REQUIRE(distances[distances.size() * 9 / 10] < 0.02);
  REQUIRE(in_sigmas[in_sigmas.size() * 9 / 10] < 3);
}

TEST_CASE("line_depth_measurement: an occluding edge has the depth of the near side") {
  const Pinhole<double> camera{268, 268, 159.5, 119.5, {}};
  testing::Image<std::uint16_t> depth(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {  // a slanted board before a wall at 5 m, its edge at x = 160
      const double inverse = 0.5 + 0.0005 * (y - 120);
      depth.view()(x, y) = static_cast<std::uint16_t>(x < 160 ? 1000 / inverse : 5000);
    }
  }
  const ImageView<const std::uint16_t> view = depth.view();
  const Vec<float, 2> start(159.5f, 40), end(159.5f, 200);
  const DepthSensor<double> sensor;
  for (const bool swapped : {false, true}) {
    const LineDepth<double> found = swapped ? measure_line_depth(camera, sensor, view, end, start)
                                            : measure_line_depth(camera, sensor, view, start, end);
    REQUIRE(found.valid);
    REQUIRE(found.inverse_depth[swapped ? 1 : 0] == Approx(0.46).margin(1e-3));
    REQUIRE(found.inverse_depth[swapped ? 0 : 1] == Approx(0.54).margin(1e-3));
  }
  // no depth, no length, out of the image
  REQUIRE_FALSE(measure_line_depth(camera, sensor, {}, start, end).valid);
  REQUIRE_FALSE(measure_line_depth(camera, sensor, view, start, start).valid);
  REQUIRE_FALSE(measure_line_depth(camera, sensor, view, Vec<float, 2>(400, 20), Vec<float, 2>(400, 200)).valid);
  REQUIRE_FALSE(measure_line_depth(camera, sensor, view, Vec<float, 2>(std::nanf(""), 20), end).valid);
}

TEST_CASE("line_depth_measurement: where two faces of a body meet, both recede and neither is at the edge's depth") {
  const Pinhole<double> camera{268, 268, 159.5, 119.5, {}};
  testing::Image<std::uint16_t> depth(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {  // seen at 45 degrees, the edge at x = 159.5 and 2 m
      const double across = (x - 159.5) / 268;
      depth.view()(x, y) = static_cast<std::uint16_t>(std::lround(10000 / (0.5 - 0.5 * std::abs(across))));
    }
  }
  DepthSensor<double> sensor;
  sensor.units_per_meter = 10000;
  const LineDepth<double> found = measure_line_depth(camera, sensor, ImageView<const std::uint16_t>(depth.view()),
                                                     Vec<float, 2>(159.5f, 40), Vec<float, 2>(159.5f, 200));
  REQUIRE(found.valid);
  REQUIRE(found.inverse_depth[0] == Approx(0.5).margin(5e-4));  // 0.0056 less 3 px beside
  REQUIRE(found.inverse_depth[1] == Approx(0.5).margin(5e-4));
}
