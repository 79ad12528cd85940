// Lines through points on rendered images, given the true poses.
#include "plumbline/frontend/collinear_segments.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

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
  std::unique_ptr<CollinearSegments<LineStore>> segments =
      std::make_unique<CollinearSegments<LineStore>>(CollinearOptions{});
  FrameWindow<double, VisualLayout, slots> window;
  std::unique_ptr<std::array<RigPyramid<Sensors>, 2>> pyramids = std::make_unique<std::array<RigPyramid<Sensors>, 2>>();
  int current = 0;

  Run() {
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

TEST_CASE("collinear_segments: a line keeps its identity from keyframe to keyframe") {
  Run run;
  std::map<std::uint32_t, int> keyframes;  // that saw the segment of a line
  run.follow(16);
  for (const auto& line : run.lines->landmarks()) {
    for (const auto& seen : line.observations) keyframes[line.id] += seen.valid && !seen.from_points;
  }
  const auto often = std::count_if(keyframes.begin(), keyframes.end(), [](const auto& k) { return k.second >= 3; });
  CAPTURE(keyframes.size(), often);
  REQUIRE(often >= 2);
  REQUIRE(median(run.errors_px()) < 1.5);
  // No two lines in space are one.
  for (const auto& a : run.lines->landmarks()) {
    for (const auto& b : run.lines->landmarks()) {
      if (a.id >= b.id || !a.located || !b.located || a.current.from_points || b.current.from_points) continue;
      if (!a.current.valid || !b.current.valid) continue;
      REQUIRE_FALSE((a.current.segment.start - b.current.segment.start).norm() +
                        (a.current.segment.end - b.current.segment.end).norm() <
                    1);
    }
  }
}

TEST_CASE("collinear_segments: a line whose points are gone goes, too") {
  Run run;
  REQUIRE(run.lines->tracked_count() > 0);
  run.points->clear();
  run.track(1);
  REQUIRE(run.lines->landmarks().empty());
}
