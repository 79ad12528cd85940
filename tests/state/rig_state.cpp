#include "plumbline/state/rig_state.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

template <class S, class Shutter>
using RigOf = Rig<Mono<Pinhole<S>, 64 * 64, Shutter>>;

}  // namespace

// The readout of a global shutter takes no memory.
static_assert(sizeof(RigState<RigOf<float, Global>>) == sizeof(SE3<float>));
static_assert(sizeof(RigState<RigOf<float, Rolling>>) >= sizeof(SE3<float>) + sizeof(ReadoutEstimate<float>));

TEMPLATE_TEST_CASE("rig_state: the estimated readout time is used", "", float, double) {
  using S = TestType;
  RigOf<S, Rolling> rig{};
  rig.vision.readout.set({S(0.01), S(0.02)});
  RigState<RigOf<S, Rolling>> rig_state(rig, {});
  REQUIRE(rig_state.readout().value_s == S(0.01));
  REQUIRE(rig_state.readout().sigma_s == S(0.02));
  REQUIRE(rig_state.correct_readout(S(0.01), S(0.001)) == Approx(0.01));
  REQUIRE(rig_state.readout().value_s == Approx(0.02));
  REQUIRE(rig_state.found_readout_s() == rig_state.readout().value_s);
  REQUIRE(rig_state.readout().sigma_s == S(0.001));
  REQUIRE(rig.vision.readout.get().value_s == S(0.01));  // the calibration stays as it is
}

TEMPLATE_TEST_CASE("rig_state: a global shutter has a readout of zero, and nothing changes that", "", float, double) {
  using S = TestType;
  const RigOf<S, Global> rig{};
  RigState<RigOf<S, Global>> rig_state(rig, {});
  REQUIRE(rig_state.readout().value_s == 0);
  REQUIRE(rig_state.readout().sigma_s == 0);
  REQUIRE(rig_state.correct_readout(S(0.01), S(0.001)) == 0);
  REQUIRE(rig_state.readout().value_s == 0);
}

TEST_CASE("rig_state: a readout that is known stays as it is") {
  RigOf<double, Rolling> rig{};
  rig.vision.readout.set({0.01, 0});
  RigState<RigOf<double, Rolling>> rig_state(rig, {});
  REQUIRE(rig_state.correct_readout(0.01, 0.001) == 0);
  REQUIRE(rig_state.readout().value_s == 0.01);
}

TEST_CASE("rig_state: extrinsics and time offset are those of the calibration until corrected") {
  Rig<Mono<Pinhole<float>>, Imu> rig{};
  rig.imu.T_body_cam = SE3<double>(SO3<double>::exp({0.1, 0.2, 0.3}), Vec<double, 3>(1, 2, 3));
  rig.imu.camera_time_offset_s = 0.01;
  RigState<Rig<Mono<Pinhole<float>>, Imu>> rig_state(rig, {});
  REQUIRE(rig_state.time_offset_s() == 0.01);
  rig_state.set_time_offset(-0.02);
  REQUIRE(rig_state.time_offset_s() == -0.02);
  REQUIRE(minus(rig_state.T_body_cam(), rig.imu.T_body_cam.cast<float>()).norm() < 1e-6f);
  REQUIRE(RigState<RigOf<double, Global>>({}, {}).T_body_cam().log().norm() == 0);
}
