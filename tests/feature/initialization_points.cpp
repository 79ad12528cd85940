#include "plumbline/feature/initialization_points.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

TEST_CASE("initialization_points: capacity, kind and kernel are part of the type, options have a name") {
  using Sensors = Rig<Mono<Pinhole<float>>>;
  STATIC_REQUIRE(InitializationPoints<50>::capacity == 50);
  STATIC_REQUIRE(std::is_same_v<InitializationPoints<50>::Kind<Sensors>, PointKind<Sensors>>);
  STATIC_REQUIRE(std::is_same_v<InitializationPoints<50, Cauchy>::Kind<Sensors>, PointKind<Sensors, Cauchy>>);
  struct : InitializationPoints<50>::Named<int> {
  } options;
  options.initialization_points = 7;
  REQUIRE(&InitializationPoints<50>::options_of(options) == &options.initialization_points);
}
