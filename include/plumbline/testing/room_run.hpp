#pragma once
/// An estimator of a camera with depth on its way through the simulated room: for examples and quick comparisons.
///
///   const testing::RoomRun run = testing::run_in_room(vo);        // two seconds at 20 Hz, with noise

#include <algorithm>
#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

namespace plumbline::testing {

struct RoomRun {
  int frames = 0, tracked = 0;
  double path_m = 0;   ///< traveled
  double error_m = 0;  ///< largest error of the motion since the first frame

  /// Every frame was tracked, and none was further off than that part of the path.
  bool is_within(double part) const { return tracked == frames && error_m < part * path_m; }
};

/// The estimator's own camera renders the room.
template <class Estimator>
RoomRun run_in_room(Estimator& estimator, int frames = 40) {
  const auto& vision = estimator.rig().vision;
  const Trajectory trajectory = *Trajectory::for_scene("room");
  const SE3<double> T_body_cam = simulated_T_body_camera();
  SimulatedCamera simulated(Renderer(*make_scene("room"), vision.camera, vision.width, vision.height), T_body_cam, {},
                            /*seed=*/1);
  const auto T_world_cam = [&](double t) { return trajectory.at(t).T_world_body * T_body_cam; };
  constexpr double start_s = 2, rate_hz = 20;
  RoomRun run;
  for (int i = 0; i < frames; ++i) {
    const double t = start_s + i / rate_hz;
    const SimulatedCamera::Frame frame = simulated.frame(trajectory, t, std::uint64_t(i));
    const auto estimate = estimator.add_frame({TimeNs(t * 1e9), frame.gray.view(), frame.depth.view()});
    ++run.frames;
    if (i > 0) run.path_m += (T_world_cam(t).p() - T_world_cam(t - 1 / rate_hz).p()).norm();
    if (!estimate || estimate->health.state != HealthState::tracking) continue;
    ++run.tracked;
    const SE3<double> truth = T_world_cam(start_s).inverse() * T_world_cam(t);  // the first camera is the world
    const Vec<double, 3> p = estimate->T_world_body.p().template cast<double>();
    run.error_m = std::max(run.error_m, (p - truth.p()).norm());
  }
  return run;
}

}  // namespace plumbline::testing
