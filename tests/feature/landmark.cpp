#include "plumbline/feature/landmark.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
using MonoGlobal = Rig<Mono<Camera, 64 * 64, Global>>;
using MonoRolling = Rig<Mono<Camera, 64 * 64, Rolling>>;
using RgbdGlobal = Rig<Rgbd<Camera, 64 * 64, Global>>;
using RgbdRolling = Rig<Rgbd<Camera, 64 * 64, Rolling>>;

template <template <class> class Kind, class Sensors>
constexpr std::size_t size_of = sizeof(Landmark<Kind<Sensors>, 10>);
template <class Sensors>
using PointsOf = PointKind<Sensors>;
template <class Sensors>
using LinesOf = LineKind<Sensors>;

/// What a sensor does not deliver takes no memory in any landmark.
template <template <class> class Kind>
constexpr bool grows_with_the_sensors =
    size_of<Kind, MonoGlobal> < size_of<Kind, MonoRolling>&& size_of<Kind, MonoRolling> <
    size_of<Kind, RgbdRolling>&& size_of<Kind, MonoGlobal> < size_of<Kind, RgbdGlobal>&& size_of<Kind, RgbdGlobal> <
    size_of<Kind, RgbdRolling>;
static_assert(grows_with_the_sensors<PointsOf> && grows_with_the_sensors<LinesOf>);

/// Nor does an IMU: it does not observe landmarks.
static_assert(size_of<PointsOf, MonoGlobal> == size_of<PointsOf, Rig<Mono<Camera, 64 * 64, Global>, Imu>>);
static_assert(size_of<LinesOf, RgbdRolling> == size_of<LinesOf, Rig<Rgbd<Camera, 64 * 64, Rolling>, Imu>>);

/// And a slot costs one observation.
static_assert(sizeof(Landmark<PointKind<MonoGlobal>, 10>) - sizeof(Landmark<PointKind<MonoGlobal>, 9>) ==
              sizeof(PointKind<MonoGlobal>::Observation));

}  // namespace

TEMPLATE_TEST_CASE("landmark: takes part when it is located and observed by another frame than its anchor", "",
                   PointKind<MonoGlobal>, LineKind<RgbdRolling>) {
  Landmark<TestType, 4> landmark;
  REQUIRE(landmark.observation_count() == 0);
  REQUIRE_FALSE(landmark.takes_part());
  landmark.anchor = 1;
  landmark.located = true;
  landmark.observations[1].valid = true;
  REQUIRE(&landmark.seen_by_anchor() == &landmark.observations[1]);
  REQUIRE_FALSE(landmark.takes_part());
  landmark.observations[3].valid = true;
  REQUIRE(landmark.observation_count() == 2);
  REQUIRE(landmark.takes_part());
  landmark.located = false;
  REQUIRE_FALSE(landmark.takes_part());
  landmark.located = true;
  landmark.observations[1].valid = false;
  landmark.observations[2].valid = true;  // two frames, but the anchor is none of them
  REQUIRE_FALSE(landmark.takes_part());
}
