#include "plumbline/map/loop_insertion.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/map/loop_finder.hpp"
#include "straight_places.hpp"

using namespace plumbline;
using test::along_x;
using test::StraightPlaces;

namespace {

using Loop = PlaceLoop<StraightPlaces::Places>;

Loop loop_of(std::uint32_t i, std::uint32_t j, double x) {
  Loop out;
  out.i = i;
  out.j = j;
  out.T_i_j = along_x(x);
  out.covariance = test::isotropic(0.01);
  return out;
}

}  // namespace

TEST_CASE("loop_insertion: a loop within a world leaves poses, and is counted") {
  StraightPlaces scene;
  scene.drive(5);
  KeyframeMapCounts counts;
  REQUIRE(insert_loop(*scene.places, loop_of(1, 5, 3.9), counts));
  CHECK((counts.loops == 1 && counts.relocalizations == 0));
  CHECK((scene.places->graph().loop(0).i == 0 && scene.places->graph().loop(0).j == 4));
  CHECK(scene.places->graph().pose(4).p().x() == 4);
  CHECK_FALSE(is_connected(*scene.places, 0));  // it connects nothing else
}

TEST_CASE("loop_insertion: the first loop puts a new world where it belongs, later ones do not move it") {
  StraightPlaces scene;
  scene.drive(4);
  scene.places->begin_world();
  scene.drive(4, 100);
  KeyframeMapCounts counts;
  CHECK_FALSE(is_connected(*scene.places, 1));
  REQUIRE(insert_loop(*scene.places, loop_of(2, 6, 0.5), counts));  // 101 of the new world is 1.5 of the map
  CHECK((is_connected(*scene.places, 1) && is_connected(*scene.places, 0)));
  CHECK((counts.loops == 1 && counts.relocalizations == 1));
  CHECK(norm(Vec<double, 3>(scene.places->S_map_world().t() - Vec<double, 3>(-99.5, 0, 0))) < 1e-12);
  CHECK(scene.places->graph().pose(7).p().x() == Approx(3.5));
  REQUIRE(insert_loop(*scene.places, loop_of(3, 7, 0.6), counts));
  CHECK((counts.loops == 2 && counts.relocalizations == 1));
  CHECK(scene.places->graph().pose(7).p().x() == Approx(3.5));
}

TEST_CASE("loop_insertion: of a full graph the loop goes whose end is nearest to that of another") {
  StraightPlaces scene;
  scene.drive(12);
  KeyframeMapCounts counts;
  for (const std::uint32_t end : {4u, 8u, 9u}) REQUIRE(insert_loop(*scene.places, loop_of(1, end, end - 1.0), counts));
  CHECK(most_crowded_loop(*scene.places) == 1);
  REQUIRE(insert_loop(*scene.places, loop_of(1, 12, 11), counts));
  const auto& graph = scene.places->graph();
  REQUIRE(graph.loops() == 3);
  int ends = 0;
  for (int l = 0; l < 3; ++l) ends |= 1 << graph.loop(l).j;
  CHECK(ends == (1 << 3 | 1 << 8 | 1 << 11));
  CHECK(counts.loops == 4);
}

TEST_CASE("loop_insertion: refuses a loop of a keyframe that was removed, and one that is no edge") {
  StraightPlaces scene;
  scene.drive(5);
  KeyframeMapCounts counts;
  Loop bad = loop_of(1, 5, 4);
  bad.covariance(2, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(insert_loop(*scene.places, bad, counts));
  REQUIRE(scene.places->remove(1));
  CHECK_FALSE(insert_loop(*scene.places, loop_of(2, 5, 3), counts));
  CHECK((counts.loops == 0 && scene.places->graph().loops() == 0));
  CHECK(insert_loop(*scene.places, loop_of(1, 5, 4), counts));
}
