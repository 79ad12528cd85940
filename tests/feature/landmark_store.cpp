// What a store does is the same for all kinds.
#include "plumbline/feature/landmark_store.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

using Sensors = Rig<Mono<Pinhole<double>, 64 * 64>>;

template <class Kind>
using Small = LandmarkStore<Kind, 4, 3>;

template <class Store>
typename Store::Landmark landmark(bool in_sight, int misses = 0) {
  typename Store::Landmark out;
  out.current.valid = in_sight;
  out.misses = misses;
  return out;
}
bool has(const auto& store, std::uint32_t id) {
  return std::any_of(store.landmarks().begin(), store.landmarks().end(), [id](const auto& x) { return x.id == id; });
}

}  // namespace

#define KINDS PointKind<Sensors>, LineKind<Sensors>
#define SCENES test::SeenPoints<double>, test::SeenLines<double>

static_assert(std::is_same_v<Small<PointKind<Sensors>>::S, double> && Small<LineKind<Sensors>>::capacity == 4);

TEMPLATE_TEST_CASE("landmark_store: a landmark begins with an id of its own, anchored where it was first seen", "",
                   KINDS) {
  using Store = Small<TestType>;
  Store store{StoreOptions{}};
  for (std::uint32_t id = 0; id < 3; ++id) {
    auto added = landmark<Store>(true);
    REQUIRE(store.add(added, int(id)));
    REQUIRE(added.id == id);
    REQUIRE(store.landmarks()[id].id == id);
    REQUIRE(store.landmarks()[id].anchor == int(id));
    REQUIRE(store.landmarks()[id].seen_by_anchor().valid);
    REQUIRE(store.landmarks()[id].observation_count() == 1);
  }
  REQUIRE(store.seen_count() == 3);
  REQUIRE(store.tracked_count() == 0);
  store.landmarks()[1].located = true;
  REQUIRE(store.tracked_count() == 1);
  store.remove_frame(2);
  auto added = landmark<Store>(true);
  REQUIRE(store.add(added, 0));
  REQUIRE(added.id == 3);  // ids are not used again
  store.clear();
  REQUIRE(store.landmarks().empty());
  REQUIRE(store.add(added, 0));
  REQUIRE(added.id == 4);
}

TEMPLATE_TEST_CASE("landmark_store: a store that is not full drops no landmark", "", KINDS) {
  using Store = Small<TestType>;
  Store store{StoreOptions{}};
  auto first = landmark<Store>(false, 9), second = landmark<Store>(true);
  REQUIRE(store.add(first, 0));
  REQUIRE(store.add(second, 0));
  REQUIRE(store.landmarks().size() == 2);
}

TEMPLATE_TEST_CASE(
    "landmark_store: the landmark missed most often makes room, of equals the oldest, never one in sight", "", KINDS) {
  using Store = Small<TestType>;
  Store store{StoreOptions{}};
  for (int misses : {3, 3, 2}) {
    auto out_of_sight = landmark<Store>(false, misses);
    REQUIRE(store.add(out_of_sight, 0));
  }
  auto in_sight = landmark<Store>(true, 9);
  REQUIRE(store.add(in_sight, 0));
  for (std::uint32_t gone : {0u, 1u, 2u}) {
    REQUIRE(has(store, gone));
    auto next = landmark<Store>(true);
    REQUIRE(store.add(next, 0));
    REQUIRE(store.landmarks().size() == 4);
    REQUIRE_FALSE(has(store, gone));
    REQUIRE(has(store, next.id));
  }
  auto one_too_many = landmark<Store>(true);
  REQUIRE_FALSE(store.add(one_too_many, 0));
  REQUIRE(store.landmarks().size() == 4);
}

TEMPLATE_TEST_CASE("landmark_store: only what may be of use again is kept", "", KINDS) {
  using Store = Small<TestType>;
  const StoreOptions options;
  const auto keeps = [&](bool in_sight, bool located, int observations, int misses) {
    Store store{options};
    auto added = landmark<Store>(in_sight, misses);
    added.located = located;
    REQUIRE(store.add(added, 0));
    for (int slot = 0; slot < 3; ++slot)
      store.landmarks()[0].observations[std::size_t(slot)].valid = slot < observations;
    store.prune();
    return !store.landmarks().empty();
  };
  REQUIRE(keeps(true, false, 1, options.max_misses + 1));  // in sight
  REQUIRE(keeps(false, true, 2, options.max_misses));      // relates two frames, may come back
  REQUIRE_FALSE(keeps(false, true, 2, options.max_misses + 1));
  REQUIRE_FALSE(keeps(false, true, 1, 0));   // seen by one frame
  REQUIRE_FALSE(keeps(false, false, 3, 0));  // lost before it was known
}

TEMPLATE_TEST_CASE("landmark_store: a frame that leaves takes along what it saw and all that is anchored in it", "",
                   SCENES) {
  TestType scene(8);
  auto& store = *scene.store;
  for (std::size_t i = 0; i < 8; ++i) store.landmarks()[i].anchor = int(i % 3);
  store.remove_frame(1);
  REQUIRE(store.landmarks().size() == 5);
  for (const auto& each : store.landmarks()) {
    REQUIRE(each.anchor != 1);
    REQUIRE_FALSE(each.observations[1].valid);
    REQUIRE(each.observations[2].valid);
  }
}

TEMPLATE_TEST_CASE("landmark_store: a frame is recorded, rejected from, and undone", "", SCENES) {
  TestType scene(6, 0);
  auto& store = *scene.store;
  const auto same = [](const auto& a, const auto& b) {
    return a.valid == b.valid && TestType::Kind::motion_px(a, b) < 1e-4;
  };
  store.begin_frame();
  for (auto& each : store.landmarks()) {
    REQUIRE(same(each.previous, each.current));
    each.current = each.observations[1];
  }
  store.reject(2);
  REQUIRE_FALSE(store.landmarks()[2].current.valid);
  REQUIRE(store.rejected().size() == 1);
  REQUIRE(store.rejected()[0].id == store.landmarks()[2].id);
  store.record(4);
  for (const auto& each : store.landmarks()) REQUIRE(same(each.observations[4], each.current));
  REQUIRE(store.seen_count() == 5);
  store.undo_frame();
  REQUIRE(store.seen_count() == 6);
  for (const auto& each : store.landmarks()) REQUIRE(same(each.current, each.observations[3]));
  store.begin_frame();
  REQUIRE(store.rejected().empty());
  store.clear_current();
  REQUIRE(store.seen_count() == 0);
  REQUIRE(store.landmarks().size() == 6);
  store.undo_frame();
  REQUIRE(store.seen_count() == 6);
}

TEMPLATE_TEST_CASE("landmark_store: motion and ranges are sums over what is in sight", "", SCENES) {
  using Kind = typename TestType::Kind;
  TestType scene(6);
  auto& store = *scene.store;
  store.landmarks()[1].current.valid = false;
  store.landmarks()[2].observations[1].valid = false;
  store.landmarks()[3].located = false;
  double motion = 0, expected_motion = 0, ranges = 0, expected_ranges = 0;
  int moved = 0, located = 0;
  store.add_motion_since(1, 1e9, motion, moved);
  store.add_inverse_ranges(ranges, located);
  for (const std::size_t i : {0u, 3u, 4u, 5u}) {
    const auto& each = store.landmarks()[i];
    expected_motion += Kind::motion_px(each.observations[1], each.current);
  }
  for (const std::size_t i : {0u, 2u, 4u, 5u}) {
    const auto& each = store.landmarks()[i];
    expected_ranges += 1 / Kind::middle(each.geometry).norm();
  }
  REQUIRE(moved == 4);
  REQUIRE(motion == Approx(expected_motion));
  // Of those that moved less than the first of them.
  double less_px = 0;
  int less = 0;
  const auto& first = store.landmarks()[0];
  store.add_motion_since(1, Kind::motion_px(first.observations[1], first.current), less_px, less);
  REQUIRE(less < 4);
  REQUIRE(less_px <= less * Kind::motion_px(first.observations[1], first.current));
  REQUIRE(located == 4);
  REQUIRE(ranges == Approx(expected_ranges));
}

TEMPLATE_TEST_CASE("landmark_store: another unit of length, another readout, for all landmarks and observations", "",
                   SCENES) {
  using Kind = typename TestType::Kind;
  TestType scene(5), other(5);
  auto &store = *scene.store, &before = *other.store;
  store.rescale(2);
  for (std::size_t i = 0; i < 5; ++i) {
    REQUIRE((Kind::middle(store.landmarks()[i].geometry) - 2 * Kind::middle(before.landmarks()[i].geometry)).norm() <
            1e-9);
  }
  store.rescale(0.5);
  store.change_readout(0.01);
  for (std::size_t i = 0; i < 5; ++i) {
    auto expected = before.landmarks()[i];
    Kind::change_readout(expected.geometry, expected.seen_by_anchor(), 0.01);
    REQUIRE((Kind::middle(store.landmarks()[i].geometry) - Kind::middle(expected.geometry)).norm() < 1e-9);
    for (auto& seen : expected.observations) seen.change_readout(0.01);
    expected.current.change_readout(0.01);
    const auto error = [](const auto& a, const auto& b) {
      if constexpr (requires { a.uv; }) {
        return double((a.uv - b.uv).norm());
      } else {
        return double((a.pixels.measured.bearing_start - b.pixels.measured.bearing_start).norm());
      }
    };
    for (std::size_t k = 0; k < 4; ++k) {
      REQUIRE(error(store.landmarks()[i].observations[k], expected.observations[k]) == 0);
    }
    REQUIRE(error(store.landmarks()[i].current, expected.current) == 0);
  }
}
