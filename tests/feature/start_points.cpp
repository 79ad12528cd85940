// Points that end with the start, on a rendered frame.
#include "plumbline/feature/start_points.hpp"

#include <memory>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

TEMPLATE_TEST_CASE("start_points: are found until the start ends, and again after a new one", "", float, double) {
  using S = TestType;
  using Sensors = Rig<Mono<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
  using Map = typename StartPoints<100>::Map<Sensors, 3>;

  const SimulatedRgbd room(1);
  Sensors rig{};
  rig.vision.camera = {S(room.camera.fx), S(room.camera.fy), S(room.camera.cx), S(room.camera.cy), {}};
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  const auto pyramid = std::make_unique<RigPyramid<Sensors>>();
  REQUIRE(pyramid->build(room.frames[0].gray.view()));
  const View<Sensors> view{rig, *pyramid, *pyramid,
                           {},  SE3<S>(), {rig.vision.camera, rig.vision.height, S(0), Vec<S, 3>::Zero()}};
  typename Map::Window window;
  const int slot = window.insert(0, SE3<S>());
  const auto map = std::make_unique<Map>(PointOptions{});

  map->insert_keyframe(view, window, slot);
  CHECK(map->landmarks().size() > 50);
  map->end_start();
  CHECK(map->landmarks().empty());
  map->insert_keyframe(view, window, slot);
  CHECK(map->landmarks().empty());
  map->clear();
  map->insert_keyframe(view, window, slot);
  CHECK(map->landmarks().size() > 50);
}
