#include "plumbline/frontend/collinear_options.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

TEST_CASE("collinear_options: without an IMU a line has at least three points") {
  CHECK(CollinearOptionsOf<Rig<Mono<Pinhole<double>>>>().min_points == 3);
  CHECK(CollinearOptionsOf<Rig<Rgbd<Pinhole<double>>>>().min_points == 3);
  CHECK(CollinearOptionsOf<Rig<Mono<Pinhole<double>>, Imu>>().min_points == 2);
}
