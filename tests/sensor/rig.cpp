#include "plumbline/sensor/rig.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

// What is absent costs nothing.
static_assert(sizeof(Rig<Mono<Pinhole<float>>>) == sizeof(Mono<Pinhole<float>>));
static_assert(sizeof(Rig<Rgbd<Pinhole<float>>>) == sizeof(Rgbd<Pinhole<float>>));
static_assert(SensorRig<Rig<Mono<Pinhole<float>>>> && SensorRig<Rig<Rgbd<Pinhole<double>>>>);
static_assert(!SensorRig<Pinhole<float>>);
static_assert(Rig<Mono<Pinhole<float>>>::state_dim == 6 && !Rig<Mono<Pinhole<float>>>::has_imu);
static_assert(Rig<Rgbd<Pinhole<float>>>::has_depth && !Rig<Mono<Pinhole<float>>>::has_depth);

TEST_CASE("rig: without an IMU the body is the camera") {
  const Rig<Mono<Pinhole<double>>> rig{{.camera = {400, 400, 320, 240, {}}, .width = 640, .height = 480}};
  REQUIRE(rig.T_body_cam().log().norm() == 0);
}
