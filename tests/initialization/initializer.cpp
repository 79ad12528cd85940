// What satisfies Initializer, by the sensors.
#include "plumbline/initialization/initializer.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/initialization/inertial.hpp"
#include "plumbline/initialization/two_view.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {
using MonoRig = Rig<Mono<Pinhole<float>, 64 * 64>>;
using MonoImuRig = Rig<Mono<Pinhole<float>, 64 * 64>, Imu>;
using RgbdImuRig = Rig<Rgbd<Pinhole<float>, 64 * 64>, Imu>;
using TwoViews = TwoViewInitializer<float, GuidedTwoView>;
using Depth = DepthInitializer<float>;

struct WithoutViews {
  static constexpr bool needs_second_view = true;
  struct Options {};
  explicit WithoutViews(const Options&) {}
  WithoutViews& visual() { return *this; }
};
}  // namespace

TEST_CASE("initializer: depth needs one view, its absence two, and an IMU an alignment") {
  STATIC_REQUIRE(Initializer<Depth, Rig<Rgbd<Pinhole<float>, 64 * 64>>>);
  STATIC_REQUIRE(Initializer<TwoViews, MonoRig>);
  STATIC_REQUIRE((!Initializer<Depth, RgbdImuRig> && !Initializer<TwoViews, MonoImuRig>));
  STATIC_REQUIRE(Initializer<InertialInitializer<float, Depth>, RgbdImuRig>);
  STATIC_REQUIRE(Initializer<InertialInitializer<float, TwoViews>, MonoImuRig>);
  STATIC_REQUIRE_FALSE(Initializer<WithoutViews, MonoRig>);
  STATIC_REQUIRE_FALSE(Initializer<int, MonoRig>);
}
