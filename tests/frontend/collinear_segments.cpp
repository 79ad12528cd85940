// Lines through points on rendered images, given the true poses.
#include "plumbline/frontend/collinear_segments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <tuple>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/scene.hpp"
#include "plumbline/testing/scenes.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

constexpr int slots = 6;
using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;
using PointStore = LandmarkStore<PointKind<Sensors>, 300, slots>;
using LineStore = LandmarkStore<CollinearKind<Sensors>, 60, slots>;

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(25);
  return simulated;
}
const SE3<double>& truth(int i) { return room().T_world_cam[std::size_t(i)]; }

double median(std::vector<double> x) {
  REQUIRE_FALSE(x.empty());
  std::nth_element(x.begin(), x.begin() + std::ptrdiff_t(x.size() / 2), x.end());
  return x[x.size() / 2];
}

struct Run {
  Sensors rig{};
  std::unique_ptr<PointStore> points = std::make_unique<PointStore>(StoreOptions{});
  std::unique_ptr<LineStore> lines = std::make_unique<LineStore>(StoreOptions{});
  PointFlow<PointStore> flow{PointFlowOptions{}};
  std::unique_ptr<CollinearSegments<LineStore>> segments;
  FrameWindow<double, VisualLayout, slots> window;
  std::unique_ptr<std::array<RigPyramid<Sensors>, 2>> pyramids = std::make_unique<std::array<RigPyramid<Sensors>, 2>>();
  int current = 0;

  explicit Run(const CollinearOptions& options = {})
      : segments(std::make_unique<CollinearSegments<LineStore>>(options)) {
    rig.vision.camera = room().camera;
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
    insert_keyframe(0);
  }

  std::tuple<const PointStore&> before() const { return std::tie(*points); }
  View<Sensors> view(int i) {
    REQUIRE((*pyramids)[std::size_t(i % 2)].build(room().frames[std::size_t(i)].gray.view()));
    current = i;
    return {room().t_ns[std::size_t(i)],
            0.05,
            rig,
            (*pyramids)[std::size_t(1 - i % 2)],
            (*pyramids)[std::size_t(i % 2)],
            room().frames[std::size_t(i)].depth.view(),
            truth(std::max(i - 1, 0)),
            {},
            {rig.vision.camera, SimulatedRgbd::height, 0.0}};
  }
  void track(int i) {
    const View<Sensors> now = view(i);
    points->begin_frame();
    lines->begin_frame();
    flow.follow(now, window, *points, truth(i));
    segments->follow(now, window, *lines, truth(i), before());
    flow.refine(now, window, *points, truth(i));
    segments->refine(now, window, *lines, truth(i), before());
    flow.locate(now, window, *points, truth(i));
    points->prune();
    segments->locate(now, window, *lines, truth(i), before());
    lines->prune();
  }
  int insert_keyframe(int i) {
    const int slot = window.insert(i, {truth(i)});
    const View<Sensors> now = view(i);
    points->record(slot);
    flow.detect(now, window, *points, slot);
    lines->record(slot);
    segments->detect(now, window, *lines, slot, before());
    return slot;
  }
  /// To frame i, with a keyframe every fourth frame.
  void follow(int i) {
    while (current < i) {
      track(current + 1);
      if (current % 4 == 0 && !window.full()) insert_keyframe(current);
    }
  }
  /// Distances [px] of what the current frame sees to the located lines, seen from the true pose.
  std::vector<double> errors_px() const {
    std::vector<double> out;
    for (const auto& line : lines->landmarks()) {
      if (!line.current.valid || !line.located) continue;
      const Plucker<double> seen =
          truth(current).inverse() * (window.T_world_body(line.anchor) * line.geometry.line.plucker());
      for (const double e : line.current.pixels.measured.residual(seen)) out.push_back(std::abs(e));
    }
    return out;
  }
};

/// A segment of a keyframe, and points of the edge in the room that it shows.
struct SeenSegment {
  std::uint32_t id;
  int slot;
  LineSegment segment;
  std::vector<Vec<double, 3>> edge;
};

/// By the true depth along the segment: an edge belongs to the nearer of the surfaces beside it.
std::vector<Vec<double, 3>> edge_points(const SE3<double>& T_world_cam, const LineSegment& segment) {
  static const testing::Scene scene = *testing::make_scene("room");
  std::vector<Vec<double, 3>> out;
  for (const float along : {0.1f, 0.3f, 0.5f, 0.7f, 0.9f}) {
    const Vec<float, 2> on_edge = segment.start + along * (segment.end - segment.start);
    double z = std::numeric_limits<double>::infinity();
    for (const float across : {-1.5f, 0.0f, 1.5f}) {
      const Vec<double, 3> ray = room().camera.unproject((on_edge + across * segment.normal()).cast<double>()).bearing;
      z = std::min(z, ray.z() * scene.intersect(T_world_cam.p(), T_world_cam.rotation() * ray));
    }
    const Vec<double, 3> ray = room().camera.unproject(on_edge.cast<double>()).bearing;
    out.push_back(T_world_cam * Vec<double, 3>(ray * (z / ray.z())));
  }
  return out;
}

/// Whether the edge of `a` is seen on the line of b's segment, bright on the same side.
bool lies_on(const SeenSegment& a, const SeenSegment& b, const SE3<double>& T_world_cam_of_b) {
  constexpr float tolerance_px = 2;
  std::vector<Vec<float, 2>> uv;
  for (const Vec<double, 3>& p : a.edge) {
    const Projection<double> projection = room().camera.project(T_world_cam_of_b.inverse() * p);
    if (!projection.valid) return false;
    uv.push_back(projection.uv.cast<float>());
    if (!(std::abs(b.segment.distance(uv.back())) < tolerance_px)) return false;
  }
  return b.segment.direction().dot(uv.back() - uv.front()) > 0;
}

}  // namespace

TEST_CASE("collinear_segments: lines of one keyframe hold points and have a place in space") {
  const Run run;
  int located = 0;
  for (const auto& line : run.lines->landmarks()) {
    REQUIRE(line.appearance.points.size() >= 2);
    REQUIRE_FALSE(line.current.from_points);
    for (const auto& member : line.appearance.points) {
      const auto& points = run.points->landmarks();
      const auto point = std::find_if(points.begin(), points.end(), [&](const auto& p) { return p.id == member.id; });
      REQUIRE(point != points.end());
      REQUIRE(std::abs(line.current.segment.distance(point->current.pixel)) < 5);
    }
    located += line.located;
  }
  CAPTURE(run.lines->landmarks().size(), located);
  REQUIRE(located >= 8);
  REQUIRE(median(run.errors_px()) < 0.6);
}

TEST_CASE("collinear_segments: between keyframes the members stand for their line") {
  Run run;
  run.track(1);
  run.track(2);
  int seen = 0;
  for (const auto& line : run.lines->landmarks()) {
    if (!line.current.valid) continue;
    REQUIRE(line.current.from_points);
    ++seen;
  }
  REQUIRE(seen >= 6);
  REQUIRE(median(run.errors_px()) < 1.5);
}

TEST_CASE("collinear_segments: a line keeps its identity from keyframe to keyframe, and two lines have two") {
  Run run;
  run.follow(20);  // six keyframes
  std::vector<SeenSegment> seen;
  for (const auto& line : run.lines->landmarks()) {
    for (int slot = 0; slot < slots; ++slot) {
      const auto& observation = line.observations[std::size_t(slot)];
      if (!observation.valid || observation.from_points) continue;
      const SE3<double> T_world_cam = run.window.T_world_body(slot);
      seen.push_back({line.id, slot, observation.segment, edge_points(T_world_cam, observation.segment)});
    }
  }
  // Pairs of segments of different keyframes: those of one id, those of one edge of the room, and both.
  int claimed = 0, same = 0, right = 0;
  for (const SeenSegment& a : seen) {
    for (const SeenSegment& b : seen) {
      if (a.slot >= b.slot) continue;
      const bool is_same =
          lies_on(a, b, run.window.T_world_body(b.slot)) && lies_on(b, a, run.window.T_world_body(a.slot));
      claimed += a.id == b.id;
      same += is_same;
      right += is_same && a.id == b.id;
    }
  }
  const double precision = double(right) / claimed, recall = double(right) / same;
  CAPTURE(seen.size(), claimed, same, right, precision, recall);
  REQUIRE(claimed >= 15);  // measured: 23, all of them right, of 33
  REQUIRE(precision >= 0.95);
  REQUIRE(recall >= 0.6);
  REQUIRE(median(run.errors_px()) < 1.5);
}

TEST_CASE("collinear_segments: a line whose points are gone goes, too") {
  Run run;
  REQUIRE(run.lines->tracked_count() > 0);
  run.points->clear();
  run.track(1);
  REQUIRE(run.lines->landmarks().empty());
}

TEST_CASE("collinear_segments: lines with fewer points than asked for are not there") {
  CollinearOptions options;
  std::size_t all = 0, before = 0;
  for (const std::size_t fewest : {2, 3, 4}) {
    options.min_points = fewest;
    Run run(options);
    std::size_t lines = 0;
    for (int i = 1; i <= 12; ++i) {
      run.follow(i);
      for (const auto& line : run.lines->landmarks())
        REQUIRE((!line.current.valid || line.appearance.points.size() >= fewest));
      lines += run.lines->landmarks().size();
    }
    REQUIRE(lines > 0);
    if (all == 0) all = before = lines;
    REQUIRE(lines <= before);
    before = lines;
  }
  REQUIRE(before < all);
}
