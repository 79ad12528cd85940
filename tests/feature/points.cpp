#include "plumbline/feature/points.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

TEST_CASE("points: capacity, kind and kernel are part of the type, options have a name") {
  using Sensors = Rig<Mono<Pinhole<float>>>;
  STATIC_REQUIRE(Points<50>::capacity == 50);
  STATIC_REQUIRE(std::is_same_v<Points<50>::Kind<Sensors>, PointKind<Sensors>>);
  STATIC_REQUIRE(std::is_same_v<Points<50, Cauchy>::Kind<Sensors>, PointKind<Sensors, Cauchy>>);
  struct : Points<50>::Named<int> {
  } options;
  options.points = 7;
  REQUIRE(&Points<50>::options_of(options) == &options.points);
}
