// The life of point landmarks on rendered frames of a room whose truth is exact.
#include "plumbline/frontend/point_flow.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <set>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(8);
  return simulated;
}

template <class S>
using RgbdRig = Rig<Rgbd<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
template <class S>
using MonoRig = Rig<Mono<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;

template <class S, int Capacity, class SensorsT = RgbdRig<S>>
struct Life {
  using Sensors = SensorsT;
  using Kind = PointKind<Sensors>;
  using Store = LandmarkStore<Kind, Capacity, 3>;
  using FrontEnd = PointFlow<Store>;

  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> previous = std::make_unique<RigPyramid<Sensors>>(),
                                       current = std::make_unique<RigPyramid<Sensors>>();
  std::unique_ptr<Store> store = std::make_unique<Store>(StoreOptions{});
  std::unique_ptr<FrontEnd> flow;
  FrameWindow<S, VisualLayout, 3> window;
  int latest = 0;
  Readout<S> readout{};
  Vec<S, 3> angular_rate = Vec<S, 3>::Zero(), velocity = Vec<S, 3>::Zero();

  explicit Life(const PointFlowOptions& options = {}) : flow(std::make_unique<FrontEnd>(options)) {
    const Pinhole<double>& camera = room().camera;
    rig.vision.camera = {S(camera.fx), S(camera.fy), S(camera.cx), S(camera.cy), {}};
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
  }

  static SE3<S> T(int i) { return room().T_world_cam[std::size_t(i)].template cast<S>(); }
  View<Sensors> view(int i) const {
    View<Sensors> out{
        room().t_ns[std::size_t(i)],
        S(0.05),
        rig,
        *previous,
        *current,
        Sensors::has_depth ? room().frames[std::size_t(i)].depth.view() : ImageView<const std::uint16_t>{},
        T(std::max(i - 1, 0)),
        SE3<S>(),
        {rig.vision.camera, rig.vision.height, readout.value_s}};
    out.shutter.set_motion(angular_rate, velocity, S(0.5));
    return out;
  }
  void show(int i) {
    std::swap(previous, current);
    REQUIRE(current->build(room().frames[std::size_t(i)].gray.view()));
  }
  int insert_keyframe(int i) {
    const int slot = window.insert(i, {T(i)});
    store->record(slot);
    flow->detect(view(i), window, *store, slot);
    return slot;
  }
  void track(int i) {
    show(i);
    store->begin_frame();
    flow->follow(view(i), window, *store, T(i));
  }
  void refine(int i) { flow->refine(view(i), window, *store, T(i)); }
  /// A window with the first frame in it.
  void begin() {
    show(0);
    insert_keyframe(0);
  }

  /// Where the truth puts a landmark in frame i [px].
  Vec<float, 2> uv_true(const typename Store::Landmark& landmark, int i) const {
    const Vec<S, 3> p_world = window.T_world_body(landmark.anchor) * Kind::middle(landmark.geometry);
    return rig.vision.camera.project(T(i).inverse() * p_world).uv.template cast<float>();
  }
  /// Median error of the observations of frame i [px], given the depths.
  float error_px(int i) const {
    std::vector<float> errors;
    for (const auto& landmark : store->landmarks()) {
      if (landmark.current.valid && landmark.located)
        errors.push_back((landmark.current.uv - uv_true(landmark, i)).norm());
    }
    const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  }
};

}  // namespace

TEMPLATE_TEST_CASE("point_flow: a keyframe fills the map with corners that have depth", "", float, double) {
  Life<TestType, 250> life;
  life.begin();
  const auto& landmarks = life.store->landmarks();
  REQUIRE(int(landmarks.size()) > 50);
  REQUIRE(int(landmarks.size()) <= PointFlowOptions{}.target_count);
  std::set<std::uint32_t> ids;
  for (const auto& landmark : landmarks) {
    ids.insert(landmark.id);
    REQUIRE(landmark.anchor == 0);
    REQUIRE(landmark.observations[0].valid);
    REQUIRE(landmark.geometry.bearing.norm() == Approx(1));
    REQUIRE(landmark.located == landmark.current.depth.get().valid);
    REQUIRE((life.rig.vision.camera.project(landmark.geometry.bearing).uv.template cast<float>() - landmark.current.uv)
                .norm() < 0.01f);
    if (!landmark.located) continue;
    const TestType z = PointKind<RgbdRig<TestType>>::middle(landmark.geometry).z();
    REQUIRE(z == Approx(1 / landmark.current.depth.get().value).epsilon(1e-4));
    REQUIRE((z > 0.3f && z < 8));
  }
  REQUIRE(ids.size() == landmarks.size());
  REQUIRE(life.store->tracked_count() > int(landmarks.size()) * 2 / 3);
}

TEMPLATE_TEST_CASE("point_flow: landmarks are followed, and alignment with the anchor keeps them there", "", float,
                   double) {
  Life<TestType, 250> life;
  life.begin();
  const int first = life.store->tracked_count();
  for (int i = 1; i < 8; ++i) {
    life.track(i);
    const float flow_error = life.error_px(i);
    life.refine(i);
    CAPTURE(i, flow_error, life.error_px(i));
    REQUIRE(flow_error < 0.3f);
    REQUIRE(life.error_px(i) < 0.3f);
    REQUIRE(life.store->tracked_count() > first * 2 / 3);
  }
}

TEST_CASE("point_flow: a landmark that was lost is found again where the pose puts it") {
  Life<float, 250> life;
  life.begin();
  for (auto& landmark : life.store->landmarks()) landmark.current.valid = false;
  life.track(1);
  REQUIRE(life.store->tracked_count() == 0);
  life.refine(1);
  REQUIRE(life.store->tracked_count() > int(life.store->landmarks().size()) / 2);
  REQUIRE(life.error_px(1) < 0.3f);
}

TEST_CASE("point_flow: searches are bounded, and every landmark has its turn") {
  PointFlowOptions options;
  options.max_searches = 20;
  Life<float, 250> life(options);
  life.begin();
  life.show(1);
  std::set<std::uint32_t> found;
  const int frames = int(life.store->landmarks().size()) / options.max_searches + 2;
  for (int k = 0; k < frames; ++k) {
    for (auto& landmark : life.store->landmarks()) landmark.current.valid = false;
    life.refine(1);
    REQUIRE(life.store->tracked_count() <= options.max_searches);
    for (const auto& landmark : life.store->landmarks()) {
      if (landmark.current.valid) found.insert(landmark.id);
    }
  }
  REQUIRE(int(found.size()) > 3 * options.max_searches);
}

TEST_CASE("point_flow: later keyframes are recorded; one that leaves takes the landmarks anchored in it along") {
  Life<float, 250> life;
  life.begin();
  const std::size_t first = life.store->landmarks().size();
  for (int i = 1; i < 7; ++i) {
    life.track(i);
    life.refine(i);
  }
  for (std::size_t i = 0; i < life.store->landmarks().size(); i += 2) life.store->reject(int(i));  // makes room
  const int slot = life.insert_keyframe(6);
  REQUIRE(slot == 1);
  REQUIRE(life.store->landmarks().size() > first);
  int again = 0;
  for (const auto& landmark : life.store->landmarks()) {
    REQUIRE(landmark.observations[1].valid == landmark.current.valid);
    again += landmark.anchor == 0 && landmark.observations[1].valid;
  }
  REQUIRE(again > int(first) / 4);
  double motion_px = 0;
  int count = 0;
  life.store->add_motion_since(0, 1e9, motion_px, count);
  REQUIRE(count == again);
  REQUIRE(motion_px > 2 * count);

  life.store->remove_frame(0);
  REQUIRE_FALSE(life.store->landmarks().empty());
  for (const auto& landmark : life.store->landmarks()) {
    REQUIRE(landmark.anchor == 1);
    REQUIRE_FALSE(landmark.observations[0].valid);
  }
}

TEST_CASE("point_flow: never more landmarks than there is room for") {
  PointFlowOptions options;
  options.target_count = 500;
  Life<float, 40> life(options);
  life.begin();
  REQUIRE(life.store->landmarks().full());
  for (int i = 1; i < 4; ++i) {
    life.track(i);
    life.refine(i);
    if (i < 3) life.insert_keyframe(i);
    REQUIRE(life.store->landmarks().size() <= 40);
    life.store->prune();
  }
  REQUIRE(life.store->tracked_count() > 20);
}

TEMPLATE_TEST_CASE("point_flow: a readout time estimated later gives the same as from the start", "", float, double) {
  using S = TestType;
  const S readout = S(0.01);
  Life<S, 250> late, known;
  known.readout.value_s = readout;
  for (auto* life : {&late, &known}) {
    life->angular_rate << S(0.3), S(-0.5), S(0.2);
    life->velocity << S(0.4), S(-0.2), S(0.3);
    life->begin();
  }
  auto& landmarks = late.store->landmarks();
  REQUIRE(landmarks.size() == known.store->landmarks().size());
  double moved = 0;
  for (const auto& landmark : landmarks)
    moved += double(landmark.current.derivative.get().by_readout().norm()) * double(readout);
  REQUIRE(moved > 0.3 * double(landmarks.size()));  // [px]
  late.store->change_readout(readout);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto &a = landmarks[i], &b = known.store->landmarks()[i];
    REQUIRE(a.geometry.bearing.norm() == Approx(1));
    REQUIRE((a.geometry.bearing - b.geometry.bearing).norm() < S(3e-5));
    REQUIRE((a.current.uv - b.current.uv).norm() < 0.03f);
    REQUIRE((a.observations[0].uv - b.observations[0].uv).norm() < 0.03f);
    REQUIRE(a.current.pixel == b.current.pixel);
  }
}

TEST_CASE("point_flow: a frame that could not be used is undone") {
  Life<float, 250> life;
  life.begin();
  life.track(1);
  std::vector<Life<float, 250>::Kind::Observation> before;
  for (const auto& landmark : life.store->landmarks()) before.push_back(landmark.previous);
  for (auto& landmark : life.store->landmarks()) landmark.current.uv.setZero();
  life.store->undo_frame();
  for (std::size_t i = 0; i < before.size(); ++i) {
    REQUIRE(life.store->landmarks()[i].current.valid == before[i].valid);
    REQUIRE(life.store->landmarks()[i].current.uv == before[i].uv);
  }
  life.store->clear();
  REQUIRE(life.store->tracked_count() == 0);
  life.refine(1);
}

TEST_CASE("point_flow: the same frames give the same landmarks to the last bit") {
  Life<float, 250> a, b;
  for (auto* life : {&a, &b}) {
    life->begin();
    for (int i = 1; i < 4; ++i) {
      life->track(i);
      life->refine(i);
    }
    life->insert_keyframe(3);
  }
  REQUIRE(a.store->landmarks().size() == b.store->landmarks().size());
  for (std::size_t i = 0; i < a.store->landmarks().size(); ++i) {
    const auto &x = a.store->landmarks()[i], &y = b.store->landmarks()[i];
    REQUIRE(x.id == y.id);
    REQUIRE(x.geometry.bearing == y.geometry.bearing);
    REQUIRE(x.current.uv == y.current.uv);
    REQUIRE(x.current.L == y.current.L);
  }
}

TEMPLATE_TEST_CASE("point_flow: a camera without depth locates by parallax", "", float, double) {
  using S = TestType;
  Life<S, 250, MonoRig<S>> life;
  life.begin();
  REQUIRE(life.store->seen_count() > 50);
  REQUIRE(life.store->tracked_count() == 0);
  for (int i = 1; i < 8; ++i) {
    life.track(i);
    life.refine(i);
  }
  life.flow->locate(life.view(7), life.window, *life.store, life.T(0));  // no motion, no parallax
  REQUIRE(life.store->tracked_count() < life.store->seen_count() / 4);
  for (auto& landmark : life.store->landmarks()) landmark.located = false;
  life.flow->locate(life.view(7), life.window, *life.store, life.T(7));
  REQUIRE(life.store->tracked_count() > 10);
  REQUIRE(life.error_px(7) < 0.5f);
  for (const auto& landmark : life.store->landmarks()) {
    if (!landmark.located) continue;
    REQUIRE(landmark.geometry.sigma_inverse_range > 0);
    REQUIRE(S(1) / landmark.geometry.inverse_range > S(0.3));
    REQUIRE(S(1) / landmark.geometry.inverse_range < S(20));
  }
}

TEMPLATE_TEST_CASE("point_flow: where one view does not suffice a keyframe and the frame must be consistent", "", float,
                   double) {
  using S = TestType;
  PointFlowOptions options;
  options.min_views = 2;
  // How many frame 7 locates: frame 4 is a keyframe that sees what is shown there, or later, or is none.
  const auto located = [&](bool is_keyframe, bool sees_later) {
    Life<S, 250, MonoRig<S>> life(options);
    life.begin();
    int slot = 0;
    for (int i = 1; i < 8; ++i) {
      life.track(i);
      life.refine(i);
      if (is_keyframe && i == 4) life.store->record(slot = life.window.insert(i, {life.T(i)}));
    }
    if (sees_later) life.store->record(slot);
    life.flow->locate(life.view(7), life.window, *life.store, life.T(7));
    if (is_keyframe && !sees_later) CHECK(life.error_px(7) < 0.5f);
    return life.store->tracked_count();
  };
  const int right = located(true, false);
  CHECK(right > 10);
  CHECK(located(true, true) < right / 4);
  CHECK(located(false, false) == 0);
}

TEST_CASE("point_flow: a landmark without depth in its keyframe is located by a later frame's") {
  Life<float, 250> life;
  life.begin();
  std::vector<float> before;
  for (auto& landmark : life.store->landmarks()) {
    before.push_back(landmark.located ? landmark.geometry.inverse_range : 0.0f);
    landmark.located = false;
  }
  for (int i = 1; i < 4; ++i) life.track(i);
  life.flow->locate(life.view(3), life.window, *life.store, life.T(3));
  REQUIRE(life.store->tracked_count() > life.store->seen_count() / 2);
  std::vector<float> errors;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto& landmark = life.store->landmarks()[i];
    if (landmark.located && before[i] > 0) errors.push_back(std::abs(landmark.geometry.inverse_range / before[i] - 1));
  }
  const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  REQUIRE(*middle < 0.02f);
}

TEMPLATE_TEST_CASE("point_flow: located landmarks in sight give correspondences with their observations", "", float,
                   double) {
  using S = TestType;
  Life<S, 250> life;
  life.begin();
  life.store->landmarks()[0].current.valid = false;
  int count = 0, with_depth = 0;
  const auto take = [&](int index, const PoseCorrespondence<S>& correspondence) {
    const auto& landmark = life.store->landmarks()[std::size_t(index)];
    REQUIRE((landmark.located && landmark.current.valid));
    REQUIRE((life.T(0).inverse() * correspondence.p_world).normalized().dot(correspondence.bearing) > S(0.9999));
    REQUIRE(correspondence.sigma_rad == Approx(1.0 / 268).epsilon(0.01));  // a pixel
    ++count;
    with_depth += correspondence.sigma_inverse_depth > landmark.current.depth.get().sigma;  // and the landmark's own
  };
  life.flow->for_each_correspondence(life.view(0), life.window, *life.store, take);
  REQUIRE(count == life.store->tracked_count());
  REQUIRE(with_depth == count);
}

TEST_CASE("point_flow: landmarks of one keyframe relate it to the latest frame") {
  Life<float, 250, MonoRig<float>> life;
  life.begin();
  for (int i = 1; i < 4; ++i) life.track(i);
  int pairs = 0;
  life.flow->for_each_pair(life.view(3), *life.store, 0, [&](const Vec<float, 3>& then, const Vec<float, 3>& now) {
    REQUIRE(then.norm() == Approx(1));
    REQUIRE(now.norm() == Approx(1));
    ++pairs;
  });
  REQUIRE(pairs == life.store->seen_count());
  life.flow->for_each_pair(life.view(3), *life.store, 1, [](const auto&, const auto&) { FAIL("of another keyframe"); });
}

TEST_CASE("point_flow: none where the mask excludes, and a point that comes there is lost") {
  constexpr int width = SimulatedRgbd::width, height = SimulatedRgbd::height;
  Life<double, 250> life;
  life.begin();
  const int before = life.store->tracked_count();
  testing::Image<std::uint8_t> used(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) used.view()(x, y) = x < width / 2 ? 255 : 0;
  }
  const auto mask = std::make_unique<ImageMask<width * height>>();
  REQUIRE(mask->set(used.view()));
  const auto check = [&] {
    for (const auto& landmark : life.store->landmarks()) {
      if (landmark.current.valid) REQUIRE_FALSE(mask->view().excludes(landmark.current.pixel));
    }
  };
  life.current->set_mask(mask->view());
  life.previous->set_mask(mask->view());
  life.track(1);
  check();
  REQUIRE(life.store->tracked_count() > before / 4);
  REQUIRE(life.store->tracked_count() < 3 * before / 4);
  life.refine(1);
  check();
  life.insert_keyframe(1);
  check();
}
