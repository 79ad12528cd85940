#include "plumbline/systems/rgbd_inertial_vio.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <type_traits>
#include <vector>

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

/// Takes every frame of the room, whose images may be made dark, with the IMU samples up to it.
template <class Look>
void fly(const test::SimulatedRgbd& world, const testing::Trajectory& trajectory, double first_s, Vio& vio,
         const std::function<bool(double t)>& is_black, Look&& look, std::uint64_t seed = 1) {
  testing::SimulatedImu simulated_imu(testing::ImuQuality{}, seed);
  testing::SimulatedImu::Measurement measured = simulated_imu.next(trajectory);
  const std::vector<std::uint8_t> black(max_pixels, 0);
  for (std::size_t i = 0; i < world.frames.size(); ++i) {
    for (; measured.sample(0).t_ns <= world.t_ns[i]; measured = simulated_imu.next(trajectory)) {
      if (measured.t >= first_s - 0.1) REQUIRE(vio.add_imu(measured.sample(0)));
    }
    const double t = 1e-9 * double(world.t_ns[i]);
    ImageView<const std::uint8_t> gray = world.frames[i].gray.view();
    if (is_black(t)) gray = {black.data(), gray.width, gray.height, gray.width};
    const Result<Estimate<double>> estimate = vio.add_frame({world.t_ns[i], gray, world.frames[i].depth.view()});
    REQUIRE(estimate);
    look(i, t, *estimate);
  }
}

std::unique_ptr<Vio> make_vio(const test::SimulatedRgbd& world, const Vio::Options& options = {}) {
  Sensors sensors{};
  sensors.vision.camera = world.camera;
  sensors.vision.width = world.width;
  sensors.vision.height = world.height;
  sensors.imu.T_body_cam = testing::simulated_T_body_camera();
  sensors.imu.noise = testing::ImuQuality{}.noise;
  return std::make_unique<Vio>(sensors, options);
}
SE3<double> true_T_world_body(const test::SimulatedRgbd& world, std::size_t i) {
  return world.T_world_cam[i] * testing::simulated_T_body_camera().inverse();
}

}  // namespace

TEST_CASE("rgbd_inertial_vio: every frame of three seconds in a room, begun in motion, over three paths") {
  constexpr double first_s = 2;
  constexpr int seeds = 3;
  // The errors are those since the first frame that tracks, so the covariance must be, too.
  Vio::Options options;
  options.backend.sigma_first_position = options.backend.sigma_first_rotation = 1e-5;
  options.calibration_error = 0;
  double nees_position = 0, nees_rotation = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto trajectory = *testing::Trajectory::for_scene("room", std::uint64_t(seed));
    const test::SimulatedRgbd world(60, first_s, 20, trajectory);
    const auto vio = make_vio(world, options);
    SE3<double> T_true_estimated;  // of the worlds: position and heading
    double path_m = 0, worst_m = 0, worst_rad = 0, worst_velocity = 0, position = 0, rotation = 0;
    int tracking = 0, with_lines = 0;
    bool started = false;
    const auto look = [&](std::size_t i, double t, const Estimate<double>& estimate) {
      if (estimate.health.state != HealthState::tracking) {
        REQUIRE_FALSE(started);
        return;
      }
      const SE3<double> T_truth = true_T_world_body(world, i);
      if (!started) {
        const Vec<double, 3> up = Vec<double, 3>::UnitZ();
        const double heading = (T_truth.rotation() * estimate.T_world_body.rotation().inverse()).log().dot(up);
        const SO3<double> R = SO3<double>::exp(heading * up);
        T_true_estimated = SE3<double>(R, T_truth.p() - R * estimate.T_world_body.p());
        started = true;
        return;
      }
      ++tracking;
      path_m += (world.T_world_cam[i].p() - world.T_world_cam[i - 1].p()).norm();
      const Vec<double, 6> e = minus(T_truth, T_true_estimated * estimate.T_world_body);
      const auto nees = [&](int at) {
        const Vec<double, 3> d = e.segment<3>(at);
        return d.dot(estimate.covariance.block<3, 3>(at, at).inverse() * d);
      };
      rotation += nees(0);
      position += nees(3);
      worst_rad = std::max(worst_rad, e.head<3>().norm());
      worst_m = std::max(worst_m, e.tail<3>().norm());
      const Vec<double, 3> v = trajectory.at(t).v_world_body;
      worst_velocity = std::max(worst_velocity, (T_true_estimated.R() * estimate.v_world_body - v).norm());
      vio->landmarks().for_each([&](const auto& store) {
        using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
        if constexpr (std::same_as<Kind, LineKind<Sensors>>) with_lines += store.tracked_count() > 0;
      });
    };
    fly(
        world, trajectory, first_s, *vio, [](double) { return false; }, look, std::uint64_t(seed));
    CAPTURE(seed, tracking, with_lines, path_m, worst_m, worst_rad, worst_velocity, position / tracking,
            rotation / tracking, name_of(vio->init_report().alignment));
    REQUIRE(vio->init_report().stage == InitStage::done);
    REQUIRE(tracking > 30);
    REQUIRE(with_lines == tracking);
    REQUIRE(path_m > 0.5);
    // Twice the worst that was measured: 0.7 % of the path, 0.013 rad, 0.006 m/s.
    CHECK(worst_m < 0.014 * path_m);
    CHECK(worst_rad < 0.026);
    CHECK(worst_velocity < 0.0126);
    nees_position += position / tracking / seeds;
    nees_rotation += rotation / tracking / seeds;
  }
  CAPTURE(nees_position, nees_rotation);
  // Of three degrees of freedom 3 is expected. Measured are 1.28 and 1.04: the covariance is safe, its sigmas are 1.5
  // and 1.7 times those of the errors. The bounds are a factor of 1.5 beside that.
  CHECK(nees_position > 0.85);
  CHECK(nees_position < 1.92);
  CHECK(nees_rotation > 0.69);
  CHECK(nees_rotation < 1.56);
}

TEST_CASE("rgbd_inertial_vio: a light that goes out as it stops finds it where it stood, however long it takes") {
  constexpr double first_s = 2, stands_s = 4, outage_s = 4.2, known_s = 5.3, bright_s = 9.5, goes_s = 10;
  auto trajectory = *testing::Trajectory::for_scene("room");
  trajectory.stop(stands_s - testing::Trajectory::ramp_s, goes_s);
  const test::SimulatedRgbd world(190, first_s, 20, trajectory);
  const auto vio = make_vio(world);
  REQUIRE(bright_s - outage_s > Vio::Options{}.recovery.max_imu_only_s);

  Vec<double, 3> p_known;
  double moved_m = 0, from_truth_m = 0;
  int lost = 0, tracking_again = 0;
  SE3<double> T_start;
  const auto look = [&](std::size_t i, double t, const Estimate<double>& estimate) {
    const Vec<double, 3> p = estimate.T_world_body.p();
    if (t < outage_s) T_start = true_T_world_body(world, i) * estimate.T_world_body.inverse();
    lost += t > stands_s && estimate.health.state == HealthState::lost;
    if (t < known_s) p_known = p;  // stationarity needs a second
    if (t > known_s && t < bright_s) moved_m = std::max(moved_m, (p - p_known).norm());
    if (t > goes_s + 0.7) {
      tracking_again += estimate.health.state == HealthState::tracking;
      from_truth_m =
          std::max(from_truth_m, ((T_start * estimate.T_world_body).p() - true_T_world_body(world, i).p()).norm());
    }
  };
  fly(
      world, trajectory, first_s, *vio, [&](double t) { return t > outage_s && t < bright_s; }, look);
  CAPTURE(moved_m, from_truth_m, lost, tracking_again);
  CHECK(lost == 0);
  CHECK(vio->latest().resets == 0);
  CHECK(moved_m < 1e-3);
  CHECK(tracking_again > 12);
  CHECK(from_truth_m < 0.03);
}
