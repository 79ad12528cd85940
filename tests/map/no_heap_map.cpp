// A keyframe map does not allocate: laps, loops, eviction, a new world.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/map/keyframe_map.hpp"
#include "simulated_places.hpp"

using namespace plumbline;

TEST_CASE("no heap: learn, recognize, solve, evict, begin a new world") {
  using Map = KeyframeMapCore<RelativePoseYawResidual<float>, 40, 200, 10>;
  const auto map = std::make_unique<Map>(KeyframeMapOptions{});
  test::SimulatedPlaces places(3);
  places.furnish(1200, 6);
  const long allocations = test::allocations_of([&] {
    map->change_world({WorldChange<float>::Kind::transformed, {}, {}});
    for (std::uint32_t id = 1; id <= 150; ++id) {
      const double a = 0.1 * id;
      const SE3<double> T = test::looking_along(a, {2 * std::cos(a), 2 * std::sin(a), 0});
      Mat<float, 6, 6> covariance = identity<float, 6>();
      for (int k = 0; k < 6; ++k) covariance(k, k) = 1e-4f * float(id);
      if (auto* keyframe = map->begin_keyframe(id, id, T.cast<float>(), {}, covariance)) {
        places.look(T, keyframe->features);
        map->finish_keyframe();
      }
      if (id > 8) map->retire(id - 8, map->places().keyframe(map->places().find(id - 8)).T_world_body);
      for (int frame = 0; frame < 5; ++frame) map->work();
      if (id == 120) map->change_world({WorldChange<float>::Kind::reset, {}, {}});
    }
  });
  REQUIRE(allocations == 0);
  CHECK(map->counts().loops > 3);
  CHECK(map->counts().corrections > 3);
  CHECK(map->counts().evicted > 50);
}
