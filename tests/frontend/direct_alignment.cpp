// Which front end a kind gets; and whole frames of direct alignment allocate nothing.
#include "allocation_counter.hpp"

#include <type_traits>

#include "catch.hpp"
#include "frontend/direct_life.hpp"
#include "plumbline/frontend/direct_alignment.hpp"

using namespace plumbline;

namespace {
using Sensors = test::DirectMono<float>;
template <class Entry>
using StoreOf = LandmarkStore<typename Entry::template Kind<Sensors>, Entry::capacity, 3>;
template <class Entry>
using FrontEndOf = DirectAlignment::Of<Entry, StoreOf<Entry>>;
}  // namespace

TEST_CASE("direct_alignment: points and lines by direct alignment, others as by flow") {
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Points<50>>, DirectPoints<StoreOf<Points<50>>>>);
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Points<50, Cauchy>>, DirectPoints<StoreOf<Points<50, Cauchy>>>>);
  STATIC_REQUIRE(
      std::is_same_v<FrontEndOf<InitializationPoints<50>>, InitializationFlow<StoreOf<InitializationPoints<50>>>>);
  STATIC_REQUIRE(std::is_same_v<FrontEndOf<Lines<20>>, DirectLines<StoreOf<Lines<20>>>>);
}

TEST_CASE("direct_alignment: whole frames allocate nothing") {
  test::DirectLife<test::DirectRgbd<float>, Features<Points<120>, Lines<40>>> life;
  life.begin();
  test::direct_room();
  int tracked = 0;
  const long allocations = test::allocations_of([&] {
    for (int i = 1; i < 6; ++i) {
      const auto view = life.view(i);
      SE3<float> T = life.T(i - 1);
      life.ends->align(view, life.window, *life.landmarks, {}, T);
      life.ends->follow(view, life.window, *life.landmarks, T);
      life.ends->find_consensus(view, life.window, *life.landmarks, {}, T);
      life.ends->refine(view, life.window, *life.landmarks, T);
      life.ends->locate(view, life.window, *life.landmarks, T);
      if (i == 3) life.keyframe(view, i);
      life.images->keep(view, T);
    }
    tracked = life.ends->lasting_count(*life.landmarks);
  });
  CHECK(allocations == 0);
  CHECK(tracked > 50);
}
