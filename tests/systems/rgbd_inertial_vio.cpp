#include "plumbline/systems/rgbd_inertial_vio.hpp"

#include <cmath>
#include <concepts>
#include <memory>
#include <type_traits>

#include "../estimator/simulation.hpp"
#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/testing/simulated_imu.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t max_pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;
using Vio = RgbdInertialVio<Pinhole<double>, max_pixels>;
using Sensors = Rig<Rgbd<Pinhole<double>, max_pixels>, Imu>;

// One line of composition, nothing else; and the parts it must have.
static_assert(std::same_as<Vio, Estimator<Sensors, Features<Points<400>, Lines<100>>, SlidingWindow<10>>>);
static_assert(std::same_as<Vio::S, double> && std::same_as<RgbdInertialVio<Pinhole<float>>::S, float>);
static_assert(Sensors::has_depth && Sensors::has_imu && Sensors::rolls && Vio::Backend::Layout::dim == 15);

}  // namespace

TEST_CASE("rgbd_inertial_vio: three seconds in a room, begun in motion") {
  constexpr int frame_count = 60;
  constexpr double first_s = 2;
  const test::SimulatedRgbd world(frame_count, first_s);
  const testing::ImuQuality quality;
  testing::SimulatedImu simulated_imu(quality, 1);
  const auto trajectory = *testing::Trajectory::for_scene("room");

  Sensors sensors{};
  sensors.vision.camera = world.camera;
  sensors.vision.width = world.width;
  sensors.vision.height = world.height;
  sensors.imu.T_body_cam = testing::simulated_T_body_camera();
  sensors.imu.noise = quality.noise;
  const auto vio = std::make_unique<Vio>(sensors);

  testing::SimulatedImu::Reading reading = simulated_imu.next(trajectory);
  const SE3<double> T_body_cam = testing::simulated_T_body_camera();
  SE3<double> T_truth_start, T_start;
  double path_m = 0, error_m = 0, velocity_error = 0;
  int tracking = 0, with_lines = 0;
  for (std::size_t i = 0; i < frame_count; ++i) {
    for (; reading.sample(0).t_ns <= world.t_ns[i]; reading = simulated_imu.next(trajectory)) {
      if (reading.t >= first_s - 0.1) REQUIRE(vio->add_imu(reading.sample(0)));
    }
    const auto& frame = world.frames[i];
    const Result<Estimate<double>> estimate = vio->add_frame({world.t_ns[i], frame.gray.view(), frame.depth.view()});
    REQUIRE(estimate);
    if (estimate->health.state != HealthState::tracking) continue;
    const SE3<double> T_truth = world.T_world_cam[i] * T_body_cam.inverse();
    if (tracking++ == 0) {
      T_truth_start = T_truth;
      T_start = estimate->T_world_body;
    }
    path_m += i > 0 ? (world.T_world_cam[i].p() - world.T_world_cam[i - 1].p()).norm() : 0;
    error_m = ((T_start.inverse() * estimate->T_world_body).p() - (T_truth_start.inverse() * T_truth).p()).norm();
    const Vec<double, 3> v_truth = trajectory.at(1e-9 * double(world.t_ns[i])).v_world_body;
    velocity_error = std::abs(estimate->v_world_body.norm() - v_truth.norm());
    vio->landmarks().for_each([&](const auto& store) {
      using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
      if constexpr (std::same_as<Kind, LineKind<Sensors>>) with_lines += store.tracked_count() > 0;
    });
  }
  CAPTURE(tracking, with_lines, path_m, error_m, velocity_error, name_of(vio->init_report().alignment));
  REQUIRE(vio->init_report().stage == InitStage::done);
  REQUIRE(tracking > 30);
  REQUIRE(with_lines == tracking);
  REQUIRE(path_m > 0.5);
  REQUIRE(error_m < 0.03 * path_m);
  REQUIRE(velocity_error < 0.05);
}
