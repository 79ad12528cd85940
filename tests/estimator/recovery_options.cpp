#include "plumbline/estimator/recovery_options.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

TEST_CASE("recovery_options: without depth a reset comes earlier, as initialization takes longer") {
  using Camera = Pinhole<float>;
  constexpr RecoveryOptions mono = default_recovery<Rig<Mono<Camera, 64 * 64>>>();
  constexpr RecoveryOptions depth = default_recovery<Rig<Rgbd<Camera, 64 * 64>>>();
  STATIC_REQUIRE(mono.max_lost_frames < depth.max_lost_frames);
  STATIC_REQUIRE(mono.max_imu_only_s == depth.max_imu_only_s);
  STATIC_REQUIRE(mono.gap_s < mono.max_imu_only_s);
}
