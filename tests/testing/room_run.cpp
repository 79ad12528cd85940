#include "plumbline/testing/room_run.hpp"

#include <optional>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {

/// The truth with a drift.
struct Oracle {
  using Sensors = Rig<Rgbd<Pinhole<double>, 160 * 128>>;
  Sensors sensors{};
  double drift_m = 0;  ///< for each frame
  int fails_at = -1;
  int frames = 0;

  Oracle() {
    sensors.vision.camera = {134, 134, 79.5, 63.5, {}};
    sensors.vision.width = 160;
    sensors.vision.height = 128;
  }
  const Sensors& rig() const { return sensors; }

  std::optional<Estimate<double>> add_frame(const Sensors::Frame& frame) {
    REQUIRE((frame.gray.width == 160 && frame.gray.height == 128 && frame.depth.width == 160));
    const auto trajectory = *testing::Trajectory::for_scene("room");
    const auto T_world_cam = [&](double t) {
      return trajectory.at(t).T_world_body * testing::simulated_T_body_camera();
    };
    Estimate<double> out;
    out.T_world_body = T_world_cam(2).inverse() * T_world_cam(1e-9 * double(frame.t_ns));
    out.T_world_body = SE3<double>(out.T_world_body.rotation(),
                                   Vec<double, 3>(out.T_world_body.p() + Vec<double, 3>(drift_m * frames, 0, 0)));
    out.health.state = frames++ == fails_at ? HealthState::lost : HealthState::tracking;
    return out;
  }
};

}  // namespace

TEST_CASE("room_run: measures the error of the estimator") {
  Oracle exact;
  const testing::RoomRun run = testing::run_in_room(exact, 5);
  REQUIRE((run.frames == 5 && run.tracked == 5));
  REQUIRE((run.path_m > 0.02 && run.error_m < 1e-6));
  REQUIRE(run.is_within(0.01));

  Oracle drifting;
  drifting.drift_m = 0.01;
  const testing::RoomRun drifted = testing::run_in_room(drifting, 5);
  REQUIRE(drifted.error_m == Approx(0.04).margin(1e-6));
  REQUIRE((drifted.path_m == run.path_m && !drifted.is_within(0.01)));
}

TEST_CASE("room_run: a frame that is not tracked is counted") {
  Oracle failing;
  failing.fails_at = 2;
  const testing::RoomRun run = testing::run_in_room(failing, 4);
  REQUIRE((run.frames == 4 && run.tracked == 3 && !run.is_within(0.01)));
}
