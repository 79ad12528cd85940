#pragma once
// A simulated RGB-D camera in the built-in room, small and fast, with exact truth.

#include <memory>
#include <vector>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

namespace plumbline::test {

struct SimulatedRgbd {
  static constexpr int width = 320, height = 240;
  Pinhole<double> camera{268, 268, 159.5, 119.5, {}};
  std::vector<testing::SimulatedCamera::Frame> frames;
  std::vector<TimeNs> t_ns;
  std::vector<SE3<double>> T_world_cam;

  explicit SimulatedRgbd(int count, double first_s = 2, double rate_hz = 20,
                         const testing::Trajectory& trajectory = *testing::Trajectory::for_scene("room")) {
    const SE3<double> T_body_cam = testing::simulated_T_body_camera();
    testing::SimulatedCamera simulated(testing::Renderer(*testing::make_scene("room"), camera, width, height, 2),
                                       T_body_cam, {}, 1);
    for (int i = 0; i < count; ++i) {
      const double t = first_s + i / rate_hz;
      frames.push_back(simulated.frame(trajectory, t, std::uint64_t(i)));
      t_ns.push_back(TimeNs(t * 1e9));
      T_world_cam.push_back(trajectory.at(t).T_world_body * T_body_cam);
    }
  }
};

}  // namespace plumbline::test
