#include "plumbline/frontend/point_flow_options.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using MonoSensor = Mono<Pinhole<float>>;
using RgbdSensor = Rgbd<Pinhole<float>>;

}  // namespace

TEST_CASE("point_flow_options: beside an IMU aligned points are worth more, tracked ones are not") {
  const PointOptionsOf<Rig<MonoSensor>> alone;
  const PointOptionsOf<Rig<MonoSensor, Imu>> beside;
  CHECK(beside.sigma_px < alone.sigma_px);
  CHECK(beside.sigma_residual < alone.sigma_residual);
  CHECK(beside.sigma_flow_px == alone.sigma_flow_px);
  CHECK(alone.sigma_px == PointFlowOptions().sigma_px);
}

TEST_CASE("point_flow_options: beside an IMU a point of a depth camera that has no depth is not located by two views") {
  CHECK(PointOptionsOf<Rig<RgbdSensor, Imu>>().min_views == 3);
  CHECK(PointOptionsOf<Rig<RgbdSensor>>().min_views == 1);
  CHECK(PointOptionsOf<Rig<MonoSensor, Imu>>().min_views == 1);  // else nothing is located at first
}
