#include "plumbline/testing/scenes.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

/// Than a room.
bool longer(std::string_view name) { return name == "hall" || name == "ring" || name == "doors" || name == "tiles"; }

}  // namespace

TEST_CASE("scenes: every name makes a closed scene of sound rectangles") {
  for (const std::string_view name : testing::scene_names) {
    const Scene scene = *make_scene(name, 3);
    for (const Rectangle& r : scene.rectangles) {
      REQUIRE((r.width > 0 && r.height > 0 && r.texel > 0));
      REQUIRE(std::abs(r.e_u.norm() - 1) < 1e-12);
      REQUIRE(std::abs(r.e_u.dot(r.e_v)) < 1e-12);
    }
    const Vec<double, 3> inside = Trajectory::for_scene(name, 3)->at(0).T_world_body.p();
    for (int i = 0; i < 2000; ++i) {  // directions of a Fibonacci sphere
      const double z = 1 - (i + 0.5) / 1000, angle = i * 2.399963, s = std::sqrt(1 - z * z);
      REQUIRE(scene.intersect(inside, {s * std::cos(angle), s * std::sin(angle), z}) < (longer(name) ? 35 : 12));
    }
  }
  REQUIRE(!make_scene("nowhere"));
}

TEST_CASE("scenes: the seed changes the surfaces, not the shapes") {
  const Scene a = *make_scene("room", 1), b = *make_scene("room", 1), c = *make_scene("room", 2);
  REQUIRE(a.rectangles.size() == b.rectangles.size());
  REQUIRE(a.rectangles[2].material.seed == b.rectangles[2].material.seed);
  REQUIRE(a.rectangles[2].material.seed != c.rectangles[2].material.seed);
  REQUIRE(a.rectangles[2].origin == c.rectangles[2].origin);
}

TEST_CASE("scenes: boxes leave out the faces on the wall and on the floor") {
  Scene scene;
  scene.add_box(placement(1, 2, 0, 0.5), {0, 0, 0}, {1, 1, 1}, Material{});
  REQUIRE(scene.rectangles.size() == 4);
  scene.add_box(placement(1, 2, 0, 0.5), {0, 0.1, 0.1}, {1, 1, 1}, Material{});
  REQUIRE(scene.rectangles.size() == 10);
  for (const Rectangle& r : scene.rectangles) {  // normals point away from the box
    const Vec<double, 3> center = placement(1, 2, 0, 0.5) * Vec<double, 3>(0.5, 0.5, 0.5);
    REQUIRE(r.normal().dot(r.origin + 0.5 * r.width * r.e_u + 0.5 * r.height * r.e_v - center) > 0.3);
  }
}
