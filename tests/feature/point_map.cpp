// The life of point landmarks on rendered frames of a room whose truth is exact.
#include "plumbline/feature/point_map.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <set>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(8);
  return simulated;
}

template <class S, int Capacity>
struct Life {
  using Sensors = Rig<Rgbd<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
  using Map = PointMap<Sensors, Capacity, 3>;

  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> previous = std::make_unique<RigPyramid<Sensors>>(),
                                       current = std::make_unique<RigPyramid<Sensors>>();
  std::unique_ptr<Map> map;
  typename Map::Window window;
  Readout<S> readout{};
  Vec<S, 3> angular_rate = Vec<S, 3>::Zero();

  explicit Life(const PointOptions& options = {}) : map(std::make_unique<Map>(options)) {
    const Pinhole<double>& camera = room().camera;
    rig.vision.camera = {S(camera.fx), S(camera.fy), S(camera.cx), S(camera.cy), {}};
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
  }

  static SE3<S> T(int i) { return room().T_world_cam[std::size_t(i)].template cast<S>(); }
  View<Sensors> view(int i) const {
    return {rig,      *previous,
            *current, room().frames[std::size_t(i)].depth.view(),
            SE3<S>(), {rig.vision.camera, rig.vision.height, readout.value_s, angular_rate}};
  }
  void show(int i) {
    std::swap(previous, current);
    REQUIRE(current->build(room().frames[std::size_t(i)].gray.view()));
  }
  int insert_keyframe(int i) {
    const int slot = window.insert(i, T(i));
    map->insert_keyframe(view(i), window, slot);
    return slot;
  }
  void track(int i) {
    show(i);
    map->track(view(i), window, T(i - 1), T(i));
  }
  /// A window with the first frame in it.
  void begin() {
    show(0);
    insert_keyframe(0);
  }

  /// Where the truth puts a landmark in frame i [px].
  Vec<float, 2> uv_true(const typename Map::Landmark& landmark, int i) const {
    const Vec<S, 3> p_world = Map::p_world(landmark, window, SE3<S>());
    return rig.vision.camera.project(T(i).inverse() * p_world).uv.template cast<float>();
  }
  /// Median error of the observations of frame i [px], given the depths.
  float error_px(int i) const {
    std::vector<float> errors;
    for (const auto& landmark : map->landmarks()) {
      if (landmark.current.valid && landmark.located)
        errors.push_back((landmark.current.uv - uv_true(landmark, i)).norm());
    }
    const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  }
};

}  // namespace

TEMPLATE_TEST_CASE("point_map: a keyframe fills the map with corners that have depth", "", float, double) {
  Life<TestType, 250> life;
  life.begin();
  const auto& landmarks = life.map->landmarks();
  REQUIRE(int(landmarks.size()) > 50);
  REQUIRE(int(landmarks.size()) <= life.map->options().target_count);
  std::set<std::uint32_t> ids;
  for (const auto& landmark : landmarks) {
    ids.insert(landmark.id);
    REQUIRE(landmark.anchor == 0);
    REQUIRE(landmark.observations[0].valid);
    REQUIRE(landmark.bearing.norm() == Approx(1));
    REQUIRE(landmark.located == landmark.current.depth.valid);
    REQUIRE((life.rig.vision.camera.project(landmark.bearing).uv.template cast<float>() - landmark.current.uv).norm() <
            0.01f);
    if (!landmark.located) continue;
    const TestType z = landmark.p_anchor_cam().z();
    REQUIRE(z == Approx(1 / landmark.current.depth.value).epsilon(1e-4));
    REQUIRE((z > 0.3f && z < 8));
  }
  REQUIRE(ids.size() == landmarks.size());
  REQUIRE(life.map->tracked_count() > int(landmarks.size()) * 2 / 3);
}

TEMPLATE_TEST_CASE("point_map: landmarks are followed, and alignment with the anchor keeps them there", "", float,
                   double) {
  Life<TestType, 250> life;
  life.begin();
  const int first = life.map->tracked_count();
  for (int i = 1; i < 8; ++i) {
    life.track(i);
    const float flow_error = life.error_px(i);
    life.map->align(life.view(i), life.window, life.T(i));
    CAPTURE(i, flow_error, life.error_px(i));
    REQUIRE(flow_error < 0.3f);
    REQUIRE(life.error_px(i) < 0.3f);
    REQUIRE(life.map->tracked_count() > first * 2 / 3);
  }
}

TEST_CASE("point_map: a landmark that was lost is found again where the pose puts it") {
  Life<float, 250> life;
  life.begin();
  for (auto& landmark : life.map->landmarks()) landmark.current.valid = false;
  life.track(1);
  REQUIRE(life.map->tracked_count() == 0);
  life.map->align(life.view(1), life.window, life.T(1));
  REQUIRE(life.map->tracked_count() > int(life.map->landmarks().size()) / 2);
  REQUIRE(life.error_px(1) < 0.3f);
}

TEST_CASE("point_map: searches are bounded, and every landmark has its turn") {
  PointOptions options;
  options.max_searches = 20;
  Life<float, 250> life(options);
  life.begin();
  life.show(1);
  std::set<std::uint32_t> found;
  const int frames = int(life.map->landmarks().size()) / options.max_searches + 2;
  for (int k = 0; k < frames; ++k) {
    for (auto& landmark : life.map->landmarks()) landmark.current.valid = false;
    life.map->align(life.view(1), life.window, life.T(1));
    REQUIRE(life.map->tracked_count() <= options.max_searches);
    for (const auto& landmark : life.map->landmarks()) {
      if (landmark.current.valid) found.insert(landmark.id);
    }
  }
  REQUIRE(int(found.size()) > 3 * options.max_searches);
}

TEMPLATE_TEST_CASE("point_map: outliers leave the frame, the pose is found", "", float, double) {
  using S = TestType;
  Life<S, 250> life;
  life.begin();
  life.track(1);
  auto& landmarks = life.map->landmarks();
  for (std::size_t i = 0; i < landmarks.size(); i += 4) landmarks[i].current.uv.x() += i % 8 == 0 ? 25 : -25;
  SE3<S> T = plus(life.T(1), (Vec<S, 6>() << S(0.01), S(-0.01), S(0.02), S(0.03), S(0.02), S(-0.03)).finished());
  life.map->reject_outliers(life.view(1), life.window, PoseRansacOptions{}, T);
  REQUIRE(minus(T, life.T(1)).template tail<3>().norm() < S(0.03));
  std::set<std::uint32_t> rejected;
  for (const auto& each : life.map->rejected()) rejected.insert(each.id);
  for (std::size_t i = 0; i < landmarks.size(); i += 4) {
    if (landmarks[i].located) REQUIRE_FALSE(landmarks[i].current.valid);
  }
  for (const auto& landmark : landmarks) {
    if (rejected.contains(landmark.id)) REQUIRE_FALSE(landmark.current.valid);
  }
  REQUIRE(rejected.size() > landmarks.size() / 8);
  REQUIRE(life.map->tracked_count() > int(landmarks.size()) / 2);
  life.track(2);
  REQUIRE(life.map->rejected().empty());
}

TEST_CASE("point_map: later keyframes are recorded; one that leaves takes the landmarks anchored in it along") {
  Life<float, 250> life;
  life.begin();
  const std::size_t first = life.map->landmarks().size();
  for (int i = 1; i < 7; ++i) {
    life.track(i);
    life.map->align(life.view(i), life.window, life.T(i));
  }
  for (std::size_t i = 0; i < life.map->landmarks().size(); i += 2) life.map->reject_current(int(i));  // makes room
  const int slot = life.insert_keyframe(6);
  REQUIRE(slot == 1);
  REQUIRE(life.map->landmarks().size() > first);
  int again = 0;
  for (const auto& landmark : life.map->landmarks()) {
    REQUIRE(landmark.observations[1].valid == landmark.current.valid);
    again += landmark.anchor == 0 && landmark.observations[1].valid;
  }
  REQUIRE(again > int(first) / 4);
  double motion_px = 0;
  int count = 0;
  life.map->add_motion_since(0, motion_px, count);
  REQUIRE(count == again);
  REQUIRE(motion_px > 2 * count);

  life.map->remove_keyframe(0);
  REQUIRE_FALSE(life.map->landmarks().empty());
  for (const auto& landmark : life.map->landmarks()) {
    REQUIRE(landmark.anchor == 1);
    REQUIRE_FALSE(landmark.observations[0].valid);
  }
}

TEST_CASE("point_map: only what may be of use again is kept") {
  PointOptions options;
  Life<float, 250> life(options);
  life.begin();
  auto& landmarks = life.map->landmarks();
  REQUIRE(landmarks.size() > 4);
  for (std::size_t i = 0; i < 4; ++i) {
    landmarks[i].located = true;
    landmarks[i].current.valid = false;
    for (auto& seen : landmarks[i].observations) seen.valid = true;
  }
  landmarks[1].misses = options.max_misses + 1;
  for (std::size_t slot = 1; slot < landmarks[2].observations.size(); ++slot) {
    landmarks[2].observations[slot].valid = false;  // one keyframe ties nothing
  }
  landmarks[3].located = false;
  const std::set<std::uint32_t> forgotten{landmarks[1].id, landmarks[2].id, landmarks[3].id};
  const std::size_t before = landmarks.size();
  life.map->prune();
  REQUIRE(landmarks.size() == before - 3);
  for (const auto& landmark : landmarks) REQUIRE(forgotten.count(landmark.id) == 0);
}

TEST_CASE("point_map: never more landmarks than there is room for") {
  PointOptions options;
  options.target_count = 500;
  Life<float, 40> life(options);
  life.begin();
  REQUIRE(life.map->landmarks().full());
  for (int i = 1; i < 4; ++i) {
    life.track(i);
    life.map->align(life.view(i), life.window, life.T(i));
    if (i < 3) life.insert_keyframe(i);
    REQUIRE(life.map->landmarks().size() <= 40);
    life.map->prune();
  }
  REQUIRE(life.map->tracked_count() > 20);
}

TEMPLATE_TEST_CASE("point_map: a readout found out later gives what it would have given from the start", "", float,
                   double) {
  using S = TestType;
  const S readout = S(0.01);
  Life<S, 250> late, known;
  known.readout.value_s = readout;
  for (auto* life : {&late, &known}) {
    life->angular_rate << S(0.3), S(-0.5), S(0.2);
    life->begin();
  }
  auto& landmarks = late.map->landmarks();
  REQUIRE(landmarks.size() == known.map->landmarks().size());
  double moved = 0;
  for (const auto& landmark : landmarks) moved += double(landmark.current.uv_slope.norm()) * double(readout);
  REQUIRE(moved > 0.3 * double(landmarks.size()));  // [px]
  late.map->change_readout(readout);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto &a = landmarks[i], &b = known.map->landmarks()[i];
    REQUIRE(a.bearing.norm() == Approx(1));
    REQUIRE((a.bearing - b.bearing).norm() < S(3e-5));
    REQUIRE((a.current.uv - b.current.uv).norm() < 0.03f);
    REQUIRE((a.observations[0].uv - b.observations[0].uv).norm() < 0.03f);
    REQUIRE(a.current.pixel == b.current.pixel);
  }
}

TEST_CASE("point_map: a frame that could not be used is undone") {
  Life<float, 250> life;
  life.begin();
  life.track(1);
  std::vector<PointObservation<float>> before;
  for (const auto& landmark : life.map->landmarks()) before.push_back(landmark.previous);
  for (auto& landmark : life.map->landmarks()) landmark.current.uv.setZero();
  life.map->undo_frame();
  for (std::size_t i = 0; i < before.size(); ++i) {
    REQUIRE(life.map->landmarks()[i].current.valid == before[i].valid);
    REQUIRE(life.map->landmarks()[i].current.uv == before[i].uv);
  }
  life.map->clear();
  REQUIRE(life.map->tracked_count() == 0);
  life.map->align(life.view(1), life.window, life.T(1));
}

TEST_CASE("point_map: the same frames give the same landmarks to the last bit") {
  Life<float, 250> a, b;
  for (auto* life : {&a, &b}) {
    life->begin();
    for (int i = 1; i < 4; ++i) {
      life->track(i);
      life->map->align(life->view(i), life->window, life->T(i));
    }
    life->insert_keyframe(3);
  }
  REQUIRE(a.map->landmarks().size() == b.map->landmarks().size());
  for (std::size_t i = 0; i < a.map->landmarks().size(); ++i) {
    const auto &x = a.map->landmarks()[i], &y = b.map->landmarks()[i];
    REQUIRE(x.id == y.id);
    REQUIRE(x.bearing == y.bearing);
    REQUIRE(x.current.uv == y.current.uv);
    REQUIRE(x.current.L == y.current.L);
  }
}
