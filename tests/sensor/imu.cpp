#include "plumbline/sensor/imu.hpp"

#include "catch.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

static_assert(Imu::is_present && !NoImu::is_present);

TEST_CASE("imu: the default extrinsics are the identity, the default time offset is zero") {
  const Imu imu;
  REQUIRE(imu.T_body_cam.log().norm() == 0);
  REQUIRE(imu.camera_time_offset_s == 0);
}
