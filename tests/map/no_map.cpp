// What is handed to a map when a frame leaves the window, and that NoMap has neither state nor effect.
#include "plumbline/map/no_map.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/simulated_points.hpp"

using namespace plumbline;

namespace {

template <class S>
using MapOf = NoMap::Map<Composition<Rig<Rgbd<Pinhole<S>>>, Features<Points<60>>, SlidingWindow<4>>>;
static_assert(std::is_same_v<MapOf<float>, NoMap::Discard<float>> &&
              std::is_same_v<MapOf<double>, NoMap::Discard<double>>);

constexpr int slots = 4;
using Sensors = Rig<Rgbd<Pinhole<double>, 64 * 64>>;
using Landmarks = Features<Points<60>>::Landmarks<Sensors, slots>;
using Window = WindowBackend<ConstantVelocity<Sensors>, Landmarks, slots>;

/// Keeps all that it is given.
struct RecordingMap {
  struct Entry {
    std::uint32_t sequence;
    TimeNs t_ns;
    SE3<double> T_world_body;
    std::vector<std::uint32_t> landmarks, observed;
    double inverse_range_sum = 0, pixel_sum = 0;
  };
  std::vector<Entry> entries;

  void on_retired(const auto& retired) {
    Entry entry{retired.sequence, retired.t_ns, retired.x.T_world_body, {}, {}};
    retired.for_each_landmark([&](const auto& landmark, const auto& seen) {
      entry.landmarks.push_back(landmark.id);
      entry.inverse_range_sum += landmark.geometry.inverse_range;
      entry.pixel_sum += double(seen.pixel.sum());
    });
    retired.for_each_observation([&](std::uint32_t id, const auto&) { entry.observed.push_back(id); });
    entries.push_back(entry);
  }
  static void work() {}
  static Sim3<double> S_map_world() { return {}; }
};

/// A window of keyframes that go past points, a little less than its size at a time.
struct Run {
  testing::SimulatedPoints points;
  testing::Gaussian noise{5};
  Sensors rig{};
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{});
  std::unique_ptr<Window> backend = std::make_unique<Window>(WindowOptions{}, ConstantVelocityOptions{});
  int keyframes = 0;

  Run() {
    points.scatter(400, {3, 2, 3}, 9);
    rig.vision.camera = {460, 460, 319.5, 239.5, {}};
  }
  void add_keyframe() {
    const SE3<double> T(SO3<double>::exp({0, 0.1 * keyframes, 0}), Vec<double, 3>(0.1 * keyframes, 0, -1));
    const TimeNs t_ns = 1000 + 50 * keyframes;
    const int slot = keyframes == 0 ? backend->start(t_ns, {T}) : backend->insert(t_ns, {T}, {});
    ++keyframes;
    auto& store = landmarks->get<0>();
    for (std::size_t i = store.landmarks().size(); i-- > 0;) {  // those out of sight make room
      if (!store.landmarks()[i].current.valid) store.landmarks().swap_remove(i);
    }
    points.observe(store, T, slot, noise);
    backend->optimize(rig, {}, *landmarks);
  }
};

/// Of an estimator with another map.
struct BigMap : NoMap {
  struct Bytes : NoMap::Discard<double> {
    using NoMap::Discard<double>::Discard;
    std::uint8_t bytes[4096];
  };
  template <class Parts>
  using Map = Bytes;
};
template <class MapPolicy>
using VoWith = Estimator<Sensors, Features<Points<60>>, SlidingWindow<slots>, NoClock, MapPolicy>;
static_assert(std::is_empty_v<NoMap::Discard<float>> && std::is_empty_v<NoMap::Discard<double>>);
static_assert(sizeof(VoWith<BigMap>) - sizeof(VoWith<NoMap>) == sizeof(BigMap::Bytes));

}  // namespace

TEST_CASE("no_map: a frame goes to the map with its state, its landmarks and what it saw of others") {
  Run run;
  RecordingMap map;
  for (int k = 0; k < 10; ++k) {
    run.add_keyframe();
    const auto& window = run.backend->window();
    if (!window.full()) continue;
    const int slot = k % 2 == 0 ? window.oldest() : window.before(window[window.newest()].sequence);
    // What must arrive, from the window before anything has left it.
    RecordingMap::Entry expected{window[slot].sequence, window[slot].t_ns, window.T_world_body(slot), {}, {}};
    for (const auto& landmark : run.landmarks->get<0>().landmarks()) {
      const auto& seen = landmark.observations[std::size_t(slot)];
      if (landmark.anchor == slot && landmark.located) {
        expected.landmarks.push_back(landmark.id);
        expected.inverse_range_sum += landmark.geometry.inverse_range;
        expected.pixel_sum += double(seen.pixel.sum());
      } else if (landmark.anchor != slot && seen.valid) {
        expected.observed.push_back(landmark.id);
      }
    }
    const std::size_t before = map.entries.size();
    run.backend->retire(run.rig, {}, *run.landmarks, slot, map);
    REQUIRE(map.entries.size() == before + 1);
    const RecordingMap::Entry& found = map.entries.back();
    CAPTURE(k, found.landmarks.size(), found.observed.size());
    CHECK(found.sequence == expected.sequence);
    CHECK(found.t_ns == expected.t_ns);
    CHECK(minus(found.T_world_body, expected.T_world_body).norm() == 0);
    CHECK(found.landmarks == expected.landmarks);
    CHECK(found.observed == expected.observed);
    CHECK(found.inverse_range_sum == expected.inverse_range_sum);
    CHECK(found.pixel_sum == expected.pixel_sum);
    for (const auto& landmark : run.landmarks->get<0>().landmarks()) REQUIRE(landmark.anchor != slot);
  }
  std::size_t with_landmarks = 0, with_others = 0;
  for (const auto& entry : map.entries) {
    with_landmarks += !entry.landmarks.empty();
    with_others += !entry.observed.empty();
  }
  REQUIRE(map.entries.size() == 7);
  REQUIRE(with_landmarks >= 3);
  REQUIRE(with_others >= 3);
}

TEST_CASE("no_map: a window is the same to the last bit whether or not a map listens") {
  Run with, without;
  RecordingMap map;
  NoMap::Discard<double> no_map;
  for (int k = 0; k < 10; ++k) {
    with.add_keyframe();
    without.add_keyframe();
    const auto &a = with.backend->window(), &b = without.backend->window();
    REQUIRE(a.T_world_body(a.newest()).p() == b.T_world_body(b.newest()).p());
    if (!a.full()) continue;
    with.backend->retire(with.rig, {}, *with.landmarks, a.oldest(), map);
    without.backend->retire(without.rig, {}, *without.landmarks, b.oldest(), no_map);
  }
  REQUIRE(map.entries.size() == 7);
}

TEMPLATE_TEST_CASE("no_map: it takes whatever leaves, and its frame is that of the odometry", "", float, double) {
  NoMap::Discard<TestType> map;
  map.on_keyframe(1);
  map.on_retired(std::string("whatever leaves"));
  map.on_world_change(1.5);
  const Sim3<TestType> S_map_world = map.S_map_world();
  CHECK(S_map_world.t().norm() == 0);
  CHECK(S_map_world.R().isIdentity(0));
  CHECK(S_map_world.scale() == 1);
}
