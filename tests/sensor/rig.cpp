#include "plumbline/sensor/rig.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
constexpr std::size_t pixels = 64 * 64;

// What is absent costs nothing.
static_assert(sizeof(Rig<Mono<Camera>>) == sizeof(Mono<Camera>));
static_assert(sizeof(Rig<Rgbd<Camera>>) == sizeof(Rgbd<Camera>));

static_assert(SensorRig<Rig<Mono<Camera>>> && SensorRig<Rig<Rgbd<Pinhole<double, RadTan>>, Imu>>);
static_assert(SensorRig<Rig<Mono<Camera, pixels, Rolling>, Imu>> && SensorRig<Rig<Rgbd<Camera, pixels, Global>>>);
static_assert(InertialRig<Rig<Mono<Camera>, Imu>> && !InertialRig<Rig<Mono<Camera>>> && !InertialRig<Imu>);
static_assert(!SensorRig<Camera> && !SensorRig<Mono<Camera>>);
static_assert(VisionSensor<Mono<Camera>> && VisionSensor<Rgbd<Camera>> && !VisionSensor<Rig<Mono<Camera>>>);

/// A camera without a shutter type.
struct WithoutShutter {
  using Camera = Pinhole<float>;
  using Scalar = float;
  struct Frame {};
  static constexpr bool has_depth = false;
  int width, height;
};
static_assert(!VisionSensor<WithoutShutter>);

static_assert(!Rig<Mono<Camera>>::has_imu && Rig<Mono<Camera>, Imu>::has_imu);
static_assert(!Rig<Mono<Camera>>::has_depth && Rig<Rgbd<Camera>>::has_depth);
static_assert(!Rig<Mono<Camera>>::rolls && Rig<Rgbd<Camera>>::rolls);  // by default
static_assert(Rig<Mono<Camera, pixels, Rolling>>::rolls && !Rig<Rgbd<Camera, pixels, Global>>::rolls);

}  // namespace

TEST_CASE("rig: without an IMU the body is the camera") {
  const Rig<Mono<Pinhole<double>>> rig{{.camera = {400, 400, 320, 240, {}}, .width = 640, .height = 480}};
  REQUIRE(rig.T_body_cam().log().norm() == 0);
}

TEST_CASE("rig: with an IMU the body is the IMU") {
  Rig<Rgbd<Camera>, Imu> rig{};
  rig.imu.T_body_cam = SE3<double>(SO3<double>::exp({0.1, 0.2, 0.3}), Vec<double, 3>(1, 2, 3));
  REQUIRE((rig.T_body_cam().p() - Vec<float, 3>(1, 2, 3)).norm() == 0);
  STATIC_REQUIRE(std::is_same_v<decltype(rig.T_body_cam()), SE3<float>>);
}
