#include "plumbline/feature/features.hpp"

#include <tuple>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

template <int N>
struct Counter {
  using Options = int;
  explicit Counter(int start) : value(start) {}
  Counter(const Counter&) = delete;  // a map is built where it stays
  int value;
};
using Two = FeatureMaps<Counter<0>, Counter<1>>;

template <class Map>
struct Terms {
  int value = 0;
};

}  // namespace

TEST_CASE("features: each map has its options, and all are visited in order") {
  Two maps(Two::Options{3, 40});
  REQUIRE(maps.get<Counter<0>>().value == 3);
  REQUIRE(maps.get<Counter<1>>().value == 40);
  int seen = 0;
  maps.for_each([&](auto& map) { seen = 100 * seen + map.value++; });
  REQUIRE(seen == 340);
  const Two& read_only = maps;
  REQUIRE(read_only.sum([](const auto& map) { return map.value; }) == 45);
  static_assert(std::is_same_v<Two::TupleOf<Terms>, std::tuple<Terms<Counter<0>>, Terms<Counter<1>>>>);
}

TEST_CASE("features: kinds become the maps of a rig, their capacities part of the type") {
  using Sensors = Rig<Rgbd<Pinhole<float>>>;
  using Maps = Features<Points<50>, Points<20>>::Maps<Sensors, 4>;
  static_assert(std::is_same_v<Maps, FeatureMaps<PointMap<Sensors, 50, 4>, PointMap<Sensors, 20, 4>>>);
  static_assert(PointMap<Sensors, 20, 4>::Landmarks::capacity() == 20);
  Maps::Options options;
  std::get<0>(options).target_count = 7;
  const Maps maps(options);
  REQUIRE(maps.get<PointMap<Sensors, 50, 4>>().options().target_count == 7);
  REQUIRE(maps.get<PointMap<Sensors, 20, 4>>().options().target_count == PointOptions{}.target_count);
}
