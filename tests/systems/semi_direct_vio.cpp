#include "plumbline/systems/semi_direct_vio.hpp"

#include <cmath>
#include <concepts>
#include <filesystem>
#include <memory>
#include <type_traits>
#include <variant>

#include "../estimator/simulation.hpp"
#include "catch.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/testing/simulated_imu.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t max_pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;
using Simulated = SemiDirectVio<Pinhole<double>, max_pixels>;
using Sensors = Rig<Mono<Pinhole<double>, max_pixels>, Imu>;

// One line of composition, nothing else; and the parts it must have.
static_assert(std::same_as<Simulated, Estimator<Sensors, Features<Points<400>, Lines<100>>, DirectGaussNewton<>>>);
static_assert(std::same_as<Simulated::S, double> && std::same_as<SemiDirectVio<Pinhole<float>>::S, float>);
static_assert(!Sensors::has_depth && Sensors::has_imu && Simulated::Backend::Layout::dim == 15);

}  // namespace

TEST_CASE("semi_direct_vio: eight seconds in a room, begun in motion") {
  constexpr int frame_count = 160;
  constexpr double first_s = 2;
  const test::SimulatedRgbd world(frame_count, first_s);
  const testing::ImuQuality quality;
  testing::SimulatedImu simulated_imu(quality, 1);
  const auto trajectory = *testing::Trajectory::for_scene("room");
  const SE3<double> T_body_cam = testing::simulated_T_body_camera();

  Sensors sensors{};
  sensors.vision.camera = world.camera;
  sensors.vision.width = world.width;
  sensors.vision.height = world.height;
  sensors.imu.T_body_cam = T_body_cam;
  sensors.imu.noise = quality.noise;
  const auto vio = std::make_unique<Simulated>(sensors);

  testing::SimulatedImu::Reading reading = simulated_imu.next(trajectory);
  io::Trajectory truth, estimated;
  double path_m = 0, velocity_error = 0;
  for (std::size_t i = 0; i < frame_count; ++i) {
    for (; reading.sample(0).t_ns <= world.t_ns[i]; reading = simulated_imu.next(trajectory)) {
      if (reading.t >= first_s - 0.1) REQUIRE(vio->add_imu(reading.sample(0)));
    }
    const Result<Estimate<double>> estimate = vio->add_frame({world.t_ns[i], world.frames[i].gray.view()});
    REQUIRE(estimate);
    if (estimate->health.state != HealthState::tracking) continue;
    path_m += (world.T_world_cam[i].p() - world.T_world_cam[i - 1].p()).norm();
    truth.push_back({world.t_ns[i], world.T_world_cam[i] * T_body_cam.inverse()});
    estimated.push_back({world.t_ns[i], estimate->T_world_body});
    const Vec<double, 3> v_truth = trajectory.at(1e-9 * double(world.t_ns[i])).v_world_body;
    velocity_error = std::abs(estimate->v_world_body.norm() - v_truth.norm());
  }
  CAPTURE(estimated.size(), path_m, velocity_error, name_of(vio->init_report().alignment));
  REQUIRE(vio->init_report().stage == InitStage::done);
  REQUIRE(estimated.size() > 30);
  REQUIRE(path_m > 0.5);
  const io::Evaluation result = io::evaluate_trajectory(truth, estimated, {.alignment = io::Alignment::posyaw});
  CAPTURE(result.ape.translation.rmse, result.scale);
  CHECK(result.ape.translation.rmse < 0.02 * path_m);
  CHECK(velocity_error < 0.05);
}

TEST_CASE("semi_direct_vio: fifteen seconds of a real flight") {
  const std::filesystem::path flight = std::filesystem::path(PLUMBLINE_TEST_DATA) / "euroc_mh01_flight";
  if (!std::filesystem::exists(flight)) {
    WARN("recording euroc_mh01_flight not found; nothing tested");
    return;
  }
  io::Recording::Options part;
  part.duration_s = 15;
  io::Recording recording = io::Recording::open(flight, part);
  const io::Calibration& calibration = recording.calibration();
  using Vio = SemiDirectVio<AnyCamera<double>>;
  Rig<Mono<AnyCamera<double>>, Imu> rig{};
  rig.vision.camera = io::make_camera<double>(calibration.camera);
  rig.vision.width = calibration.camera.width;
  rig.vision.height = calibration.camera.height;
  rig.imu.T_body_cam = *calibration.T_body_camera;
  rig.imu.noise = *calibration.imu;
  const auto vio = std::make_unique<Vio>(rig);
  io::Trajectory estimated;
  int lost = 0;
  io::Recording::Sample sample;
  while (recording.next(sample)) {
    if (const auto* imu = std::get_if<ImuSample>(&sample)) {
      (void)vio->add_imu(*imu);
      continue;
    }
    const auto& frame = std::get<io::FrameSample>(sample);
    const cv::Mat gray = opencv::read_gray(frame.image);
    const auto estimate = vio->add_frame({frame.t_ns, opencv::view<std::uint8_t>(gray)});
    REQUIRE(estimate);
    lost += estimate->health.state == HealthState::lost;
    if (estimate->health.state != HealthState::initializing) estimated.push_back({frame.t_ns, estimate->T_world_body});
  }
  const io::Evaluation result =
      io::evaluate_trajectory(*recording.read_groundtruth(true), estimated, {.alignment = io::Alignment::posyaw});
  CAPTURE(result.ape.translation.rmse, result.scale, estimated.size());
  CHECK(lost == 0);
  CHECK(estimated.size() > 240);
  CHECK(result.ape.translation.rmse < 0.12);
}
