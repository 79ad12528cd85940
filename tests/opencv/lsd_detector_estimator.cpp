// The whole estimator with lines that LSD finds, on rendered images.
#include <memory>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/opencv/lsd_detector.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

TEST_CASE("lsd_detector_estimator: follows a simulated room by lines alone") {
  using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;
  using OfLines = Estimator<Sensors, Features<Lines<100, opencv::LsdDetector<>>>, SlidingWindow<6>>;
  constexpr int frames = 60;
  const SimulatedRgbd room(frames);
  Sensors rig{};
  rig.vision.camera = room.camera;
  rig.vision.width = SimulatedRgbd::width;
  rig.vision.height = SimulatedRgbd::height;
  const auto vio = std::make_unique<OfLines>(rig);
  double worst = 0, path = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const Result<Estimate<double>> estimate =
        vio->add_frame({room.t_ns[i], room.frames[i].gray.view(), room.frames[i].depth.view()});
    REQUIRE(estimate);
    REQUIRE(estimate->health.state == HealthState::tracking);
    const SE3<double> truth = room.T_world_cam[0].inverse() * room.T_world_cam[i];
    worst = std::max(worst, (estimate->T_world_body.p() - truth.p()).norm());
    if (i > 0) path += (room.T_world_cam[i].p() - room.T_world_cam[i - 1].p()).norm();
  }
  CAPTURE(worst, path);
  REQUIRE(path > 0.8);
  REQUIRE(worst < 0.05 * path);  // 320x240 pixels, noisy depth
}
