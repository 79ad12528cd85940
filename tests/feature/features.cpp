#include "plumbline/feature/features.hpp"

#include <tuple>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

template <int N>
struct Counter {
  explicit Counter(int start) : value(start) {}
  Counter(const Counter&) = delete;  // a store is built where it stays
  int value;
};
using Three = LandmarkSet<Counter<0>, Counter<1>, Counter<2>>;

template <class Store>
struct Terms {
  int value = 0;
};

}  // namespace

TEST_CASE("features: each store has its options, and all are visited in order") {
  Three stores(3, 40, 500);
  REQUIRE(stores.get<0>().value == 3);
  REQUIRE(stores.get<2>().value == 500);
  int seen = 0;
  stores.for_each([&](auto& store) { seen = 10 * seen + store.value++; });
  REQUIRE(seen == 300 + 400 + 500);
  const Three& read_only = stores;
  int sum = 0;
  read_only.for_each([&](const auto& store) { sum += store.value; });
  REQUIRE(sum == 546);
  int order = 0;
  Three::for_each_index([&]<std::size_t I>() { order = 10 * order + int(I); });
  REQUIRE(order == 12);
}

TEST_CASE("features: parts belong to the stores by place") {
  Three stores(3, 40, 500);
  std::tuple<Terms<Counter<0>>, Terms<Counter<1>>, Terms<Counter<2>>> parts;
  STATIC_REQUIRE(std::is_same_v<Three::TupleOf<Terms>, decltype(parts)>);
  stores.for_each_with(parts, [](auto& store, auto& part) { part.value = store.value + 1; });
  REQUIRE(std::get<1>(parts).value == 41);
  int sum = 0;
  const Three& read_only = stores;
  read_only.for_each_with(parts, [&](const auto& store, const auto& part) { sum += part.value - store.value; });
  REQUIRE(sum == 3);
}

TEST_CASE("features: a kind reads those named before it") {
  Three stores(3, 40, 500);
  STATIC_REQUIRE(std::is_same_v<decltype(stores.before<2>()), std::tuple<const Counter<0>&, const Counter<1>&>>);
  STATIC_REQUIRE(std::tuple_size_v<decltype(stores.before<0>())> == 0);
  const auto before = stores.before<2>();
  REQUIRE(&std::get<1>(before) == &stores.get<1>());
}

TEST_CASE("features: entries become the stores of a rig, their capacities part of the type") {
  using Sensors = Rig<Rgbd<Pinhole<float>, 64 * 64>>;
  using Set = Features<Points<50>, Lines<20>, Points<10>>;
  using Landmarks = Set::Landmarks<Sensors, 4>;
  STATIC_REQUIRE(std::is_same_v<Set::StoreOf<Lines<20>, Sensors, 4>, LandmarkStore<LineKind<Sensors>, 20, 4>>);
  STATIC_REQUIRE(
      std::is_same_v<Landmarks,
                     LandmarkSet<LandmarkStore<PointKind<Sensors>, 50, 4>, LandmarkStore<LineKind<Sensors>, 20, 4>,
                                 LandmarkStore<PointKind<Sensors>, 10, 4>>>);
  const StoreOptions options;
  const Landmarks landmarks(options, options, options);
  int capacity = 0;
  landmarks.for_each([&](const auto& store) { capacity += store.capacity; });
  REQUIRE(capacity == 80);
  REQUIRE(landmarks.seen_count() == 0);
}

TEST_CASE("features: lines that are known by their points are not counted beside them") {
  const StoreOptions options;
  using Sensors = Rig<Rgbd<Pinhole<float>, 64 * 64>>;
  using Held = Features<Points<50>, Collinear<20>>::Landmarks<Sensors, 4>;
  Held landmarks(options, options);
  const auto seen = [](auto landmark) {
    landmark.current.valid = landmark.located = true;
    return landmark;
  };
  for (int i = 0; i < 3; ++i)
    landmarks.get<0>().landmarks().push_back(seen(std::remove_cvref_t<decltype(landmarks.get<0>())>::Landmark{}));
  landmarks.get<1>().landmarks().push_back(seen(std::remove_cvref_t<decltype(landmarks.get<1>())>::Landmark{}));
  REQUIRE(landmarks.get<1>().tracked_count() == 1);
  REQUIRE(landmarks.seen_count() == 3);
  REQUIRE(landmarks.tracked_count() == 3);
}
