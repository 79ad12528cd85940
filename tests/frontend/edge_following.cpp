// Lines on rendered images, given the true poses or wrong ones.
#include "plumbline/frontend/edge_following.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

constexpr int slots = 4;
using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(13);
  return simulated;
}
const SE3<double>& truth(int i) { return room().T_world_cam[std::size_t(i)]; }

double median(std::vector<double> x) {
  REQUIRE_FALSE(x.empty());
  std::nth_element(x.begin(), x.begin() + std::ptrdiff_t(x.size() / 2), x.end());
  return x[x.size() / 2];
}

template <int N>
struct Run {
  using Kind = LineKind<Sensors>;
  using Store = LandmarkStore<Kind, N, slots>;
  using FrontEnd = EdgeFollowing<Store>;
  Sensors rig{};
  bool with_depth = true;
  std::unique_ptr<Store> store = std::make_unique<Store>(StoreOptions{});
  std::unique_ptr<FrontEnd> edges = std::make_unique<FrontEnd>(EdgeFollowingOptions{});
  FrameWindow<double, VisualLayout, slots> window;
  std::unique_ptr<std::array<RigPyramid<Sensors>, 2>> pyramids = std::make_unique<std::array<RigPyramid<Sensors>, 2>>();
  int current = 0;

  explicit Run(bool depth = true) : with_depth(depth) {
    rig.vision.camera = room().camera;
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
    insert_keyframe(0);
  }

  View<Sensors> view(int i) {
    REQUIRE((*pyramids)[std::size_t(i % 2)].build(room().frames[std::size_t(i)].gray.view()));
    current = i;
    return {room().t_ns[std::size_t(i)],
            0.05,
            rig,
            (*pyramids)[std::size_t(1 - i % 2)],
            (*pyramids)[std::size_t(i % 2)],
            with_depth ? room().frames[std::size_t(i)].depth.view() : ImageView<const std::uint16_t>{},
            truth(std::max(i - 1, 0)),
            {},
            {rig.vision.camera, SimulatedRgbd::height, 0.0}};
  }
  void track(int i, const SE3<double>& T_predicted) {
    store->begin_frame();
    edges->follow(view(i), window, *store, T_predicted);
  }
  void refine(int i, const SE3<double>& T) { edges->refine(view(i), window, *store, T); }
  void locate(int i) { edges->locate(view(i), window, *store, truth(i)); }
  int insert_keyframe(int i) {
    const int slot = window.insert(i, {truth(i)});
    store->record(slot);
    edges->detect(view(i), window, *store, slot);
    return slot;
  }
  /// To frame i with true poses.
  void follow(int i) {
    while (current < i) {
      track(current + 1, truth(current + 1));
      refine(current, truth(current));
    }
  }
  Vec<double, 3> p_world(const typename Store::Landmark& landmark) const {
    return window.T_world_body(landmark.anchor) * landmark.geometry.middle();
  }
  /// Distances [px] of what the current frame sees to the located lines, seen from the true pose.
  std::vector<double> errors_px() const {
    std::vector<double> out;
    for (const auto& landmark : store->landmarks()) {
      if (!landmark.current.valid || !landmark.located) continue;
      const Plucker<double> line =
          truth(current).inverse() * (window.T_world_body(landmark.anchor) * landmark.geometry.line.plucker());
      for (const double e : landmark.current.pixels.measured.residual(line)) out.push_back(std::abs(e));
    }
    return out;
  }
};

}  // namespace

TEST_CASE("edge_following: lines located by one depth image fit the next frames") {
  Run<60> run;
  const int first = run.store->tracked_count();
  REQUIRE(first >= 20);
  run.follow(10);
  const int left = run.store->tracked_count();
  const std::vector<double> errors = run.errors_px();
  CAPTURE(first, left, median(errors));
  REQUIRE(left > 0.6 * first);
  REQUIRE(median(errors) < 0.6);
  double inverse_sum = 0, motion_px = 0;
  int count = 0, moved = 0;
  run.store->add_inverse_ranges(inverse_sum, count);
  REQUIRE(count == left);
  REQUIRE(count / inverse_sum > 1);
  REQUIRE(count / inverse_sum < 4);
  run.store->add_motion_since(0, 1e9, motion_px, moved);
  REQUIRE(moved >= left);
  // The mean over lines of all directions is near the mean motion of the image.
  double flow_px = 0;
  for (const auto& landmark : run.store->landmarks()) {
    if (!landmark.current.valid || !landmark.located) continue;
    const Vec<double, 3> p = run.p_world(landmark);
    flow_px +=
        (room().camera.project(truth(0).inverse() * p).uv - room().camera.project(truth(10).inverse() * p).uv).norm() /
        left;
  }
  CAPTURE(motion_px / moved, flow_px);
  REQUIRE(motion_px / moved > 0.4 * flow_px);
  REQUIRE(motion_px / moved < 2 * flow_px);
}

TEST_CASE(
    "edge_following: a prediction some pixels off loses little, and what is lost is found again where the pose is "
    "right") {
  Run<60> right, wrong;
  const int first = right.store->tracked_count();
  for (int i = 1; i <= 5; ++i) {
    right.follow(i);
    const double sign = i % 2 == 0 ? 1 : -1;
    wrong.track(i, plus(truth(i), Vec<double, 6>(sign * Vec<double, 6>(0.015, 0.02, 0.01, 0, 0, 0))));  // 5 px
    wrong.refine(i, truth(i));
  }
  REQUIRE(right.store->tracked_count() > 0.7 * first);
  REQUIRE(wrong.store->tracked_count() > 0.9 * right.store->tracked_count());
  REQUIRE(median(wrong.errors_px()) < 0.6);

  const int tracked = right.store->tracked_count();
  for (std::size_t i = 0; i < right.store->landmarks().size(); ++i) {
    right.store->reject(int(i));
  }
  REQUIRE(right.store->tracked_count() == 0);
  REQUIRE(right.store->rejected().size() == right.store->landmarks().size());
  right.refine(5, truth(5));
  REQUIRE(right.store->tracked_count() > 0.8 * tracked);
  right.follow(6);
  REQUIRE(right.store->rejected().empty());
}

TEST_CASE("edge_following: without depth, lines come from two views with parallax") {
  Run<60> run(false);
  REQUIRE(run.store->tracked_count() == 0);
  REQUIRE(run.store->landmarks().size() > 20);
  run.locate(0);  // no parallax
  REQUIRE(run.store->tracked_count() == 0);
  run.follow(12);
  run.locate(12);
  REQUIRE(run.store->tracked_count() >= 5);
  std::vector<double> errors;  // of inverse depth, in sigmas of the line's and 2 % of the depth image's
  const ImageView<const std::uint16_t> depth = room().frames[12].depth.view();
  for (const auto& landmark : run.store->landmarks()) {
    if (!landmark.current.valid || !landmark.located) continue;
    const Vec<double, 3> p = truth(12).inverse() * run.p_world(landmark);
    const Vec<double, 2> uv = room().camera.project(p).uv;
    if (!depth.contains(float(uv.x()), float(uv.y()), 2.0f)) continue;
    double nearest = 1e9;  // an edge is where depth changes
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const double z = depth(int(uv.x()) + dx, int(uv.y()) + dy) / 1000.0;
        if (z > 0) nearest = std::min(nearest, std::abs(z - p.z()) / p.z());
      }
    }
    errors.push_back(nearest);
  }
  CAPTURE(errors.size());
  REQUIRE(median(errors) < 0.05);
}

TEST_CASE("edge_following: one landmark for each edge, never more than there is room for") {
  Run<12> run;
  REQUIRE(run.store->landmarks().full());
  run.follow(6);
  run.insert_keyframe(6);
  REQUIRE(run.store->landmarks().size() <= 12);

  Run<60> large;
  large.follow(6);
  large.insert_keyframe(6);
  const MergeOptions overlapping{.max_gap_px = 0};
  for (const auto& a : large.store->landmarks()) {
    for (const auto& b : large.store->landmarks()) {
      if (a.id == b.id || !a.current.valid || !b.current.valid) continue;
      REQUIRE_FALSE(are_one(a.current.segment, b.current.segment, overlapping));
    }
  }
}

TEST_CASE("edge_following: a pose that is no number finds nothing, and the frame can be taken back") {
  Run<60> run;
  const int tracked = run.store->tracked_count();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SE3<double> nowhere(SO3<double>(), Vec<double, 3>::Constant(nan));
  run.track(1, nowhere);
  run.refine(1, nowhere);
  REQUIRE(run.store->tracked_count() == 0);
  run.store->undo_frame();
  REQUIRE(run.store->tracked_count() == tracked);
  run.store->prune();
  REQUIRE(run.store->tracked_count() == tracked);
}

TEST_CASE(
    "edge_following: landmarks go with their anchor, when they are lost before they are known, and when all is "
    "cleared") {
  Run<60> run;
  run.store->landmarks().resize(40);
  run.follow(6);
  const int slot = run.insert_keyframe(6);
  const std::size_t all = run.store->landmarks().size();
  std::size_t of_first = 0;
  for (const auto& landmark : run.store->landmarks()) of_first += landmark.anchor != slot;
  REQUIRE(of_first > 0);
  REQUIRE(of_first < all);
  run.store->remove_frame(0);
  REQUIRE(run.store->landmarks().size() == all - of_first);
  for (const auto& landmark : run.store->landmarks()) REQUIRE(landmark.anchor == slot);

  auto& known = run.store->landmarks()[0];
  known.located = true;
  known.current.valid = false;
  for (auto& seen : known.observations) seen = run.store->landmarks()[1].current, seen.valid = true;
  run.store->landmarks()[1].current.valid = false;  // one observation is not enough to wait for it
  const std::uint32_t kept = known.id, dropped = run.store->landmarks()[1].id;
  run.store->prune();
  const auto has = [&](std::uint32_t id) {
    return std::any_of(run.store->landmarks().begin(), run.store->landmarks().end(),
                       [&](const auto& landmark) { return landmark.id == id; });
  };
  REQUIRE(has(kept));
  REQUIRE_FALSE(has(dropped));
  run.store->clear();
  REQUIRE(run.store->landmarks().empty());
}
