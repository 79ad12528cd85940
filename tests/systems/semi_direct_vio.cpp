#include "plumbline/systems/semi_direct_vio.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <functional>
#include <memory>
#include <variant>
#include <vector>

#include <opencv2/imgproc.hpp>

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

constexpr int frame_count = 280;
/// The first seconds are not sure of their scale: 0.03 to 0.3 m by the moment in which they begin.
constexpr double rough_m = 0.25;
constexpr double rate_hz = 20;

/// What the camera sees, from a time of its way on [s].
struct World {
  double first_s;
  testing::Trajectory trajectory;
  test::SimulatedRgbd seen;

  World(double begin_s, int frames, const testing::Trajectory& way)
      : first_s(begin_s), trajectory(way), seen(frames, begin_s, rate_hz, way) {}
};
testing::Trajectory room() { return *testing::Trajectory::for_scene("room"); }
const World& in_motion() {
  static const World world(2, frame_count, room());
  return world;
}
/// The body is stationary for a second, then gains speed.
const World& is_stationary_first() {
  static const World world(0, 160, room());
  return world;
}
/// It stops within half a second, and is stationary.
World coming_to_a_halt() {
  testing::Trajectory way = room();
  way.stop(3, 30);
  return World(3.5, 60, way);
}
SE3<double> T_body_cam() { return testing::simulated_T_body_camera(); }

/// Fourteen seconds in a room, initialized in motion; or eight, initialized while stationary.
struct RoomFlight {
  using Change = std::function<bool(double t, cv::Mat& image, bool follows_keyframe)>;

  const World& world;
  InitReport init;
  std::vector<Estimate<double>> estimates;

  /// `change` sees every image at its time since the first one [s]; false takes it away.
  explicit RoomFlight(
      const Change& change = [](double, cv::Mat&, bool) { return true; }, const World& flown = in_motion())
      : world(flown) {
    const testing::Trajectory& trajectory = world.trajectory;
    const testing::ImuQuality quality;
    testing::SimulatedImu simulated_imu(quality, 1);
    Sensors sensors{};
    sensors.vision.camera = world.seen.camera;
    sensors.vision.width = test::SimulatedRgbd::width;
    sensors.vision.height = test::SimulatedRgbd::height;
    sensors.imu.T_body_cam = T_body_cam();
    sensors.imu.noise = quality.noise;
    const auto vio = std::make_unique<Simulated>(sensors);
    testing::SimulatedImu::Measurement measured = simulated_imu.next(trajectory);
    for (std::size_t i = 0; i < world.seen.frames.size(); ++i) {
      for (; measured.sample(0).t_ns <= world.seen.t_ns[i]; measured = simulated_imu.next(trajectory)) {
        if (measured.t >= world.first_s - 0.1) REQUIRE(vio->add_imu(measured.sample(0)));
      }
      cv::Mat image = opencv::mat(world.seen.frames[i].gray.view()).clone();
      const bool follows_keyframe = i > 0 && vio->latest().keyframe && vio->latest().t_ns == world.seen.t_ns[i - 1];
      if (!change(double(i) / rate_hz, image, follows_keyframe)) continue;
      const auto estimate = vio->add_frame({world.seen.t_ns[i], opencv::view<std::uint8_t>(image)});
      REQUIRE(estimate);
      REQUIRE((estimate->T_world_body.is_finite() && estimate->covariance.allFinite()));
      estimates.push_back(*estimate);
    }
    init = vio->init_report();
  }

  /// RMS error of the positions from `from` to `to` [s], aligned in position and heading.
  double ate(double from = 0, double to = frame_count / rate_hz) const {
    io::Trajectory truth, estimated;
    for (const Estimate<double>& estimate : estimates) {
      const double t = time_of(estimate);
      if (t < from || t > to || estimate.health.state == HealthState::initializing) continue;
      truth.push_back({estimate.t_ns, T_world_body(t)});
      estimated.push_back({estimate.t_ns, estimate.T_world_body});
    }
    return io::evaluate_trajectory(truth, estimated, {.alignment = io::Alignment::posyaw}).ape.translation.rmse;
  }
  SE3<double> T_world_body(double t) const {
    return world.seen.T_world_cam[std::size_t(std::lround(t * rate_hz))] * T_body_cam().inverse();
  }
  double time_of(const Estimate<double>& estimate) const { return 1e-9 * double(estimate.t_ns) - world.first_s; }
  /// Share of the frames from `from` to `to` [s].
  double part(HealthState state, double from, double to) const {
    int n = 0, all = 0;
    for (const Estimate<double>& estimate : estimates) {
      const double t = time_of(estimate);
      if (t < from || t > to) continue;
      ++all;
      n += estimate.health.state == state;
    }
    return double(n) / all;
  }
};

bool during(double t, double from, double to) { return t >= from && t < to; }

}  // namespace

TEST_CASE("semi_direct_vio: fourteen seconds in a room, initialized in motion") {
  const RoomFlight run;
  CAPTURE(run.ate(), run.part(HealthState::tracking, 9, 14), name_of(run.init.alignment));
  REQUIRE(run.init.stage == InitStage::done);
  CHECK(run.part(HealthState::tracking, 9, 14) == 1);
  CHECK(run.ate() < rough_m);
  CHECK(run.ate(8, 14) < 0.02);
  const double t = 1e-9 * double(run.estimates.back().t_ns);
  const Vec<double, 3> v_truth = testing::Trajectory::for_scene("room")->at(t).v_world_body;
  CHECK(std::abs(run.estimates.back().v_world_body.norm() - v_truth.norm()) < 0.05);
}

TEST_CASE("semi_direct_vio: a body that stops before initialization has a stationary pose") {
  const World world = coming_to_a_halt();
  const RoomFlight run([](double, cv::Mat&, bool) { return true; }, world);
  int poses = 0;
  for (const Estimate<double>& estimate : run.estimates) {
    const double since_halt_s = run.time_of(estimate) - 0.5;
    CAPTURE(since_halt_s);
    if (since_halt_s > 1.3) CHECK(estimate.health.state == HealthState::degraded);
    poses += estimate.health.state == HealthState::degraded;
  }
  CHECK(poses > 20);
  const Estimate<double>& last = run.estimates.back();
  CHECK(last.health.reason == HealthReason::aligning);
  CHECK(last.v_world_body.norm() == 0);
  CHECK((last.T_world_body.rotation().inverse() * Vec<double, 3>::UnitZ() -
         run.T_world_body(2.95).rotation().inverse() * Vec<double, 3>::UnitZ())
            .norm() < 0.03);
}

// What is found again after two seconds hangs on the moment: one of six leaves 0.12 m, or 0.06 m.
TEST_CASE("semi_direct_vio: black images for two seconds, at five times") {
  std::vector<double> errors;
  for (const double begin_s : {8.0, 8.2, 8.4, 8.6, 8.8}) {
    const double end_s = begin_s + 2;
    const RoomFlight run([&](double t, cv::Mat& image, bool) {
      if (during(t, begin_s, end_s)) image.setTo(0);
      return true;
    });
    CAPTURE(begin_s, run.ate(), run.ate(8, 14.5));
    CHECK(run.init.stage == InitStage::done);
    CHECK(run.ate() < rough_m);
    CHECK(run.part(HealthState::tracking, begin_s + 0.05, end_s - 0.05) == 0);
    CHECK(run.part(HealthState::lost, 0, 14) == 0);
    CHECK(run.part(HealthState::tracking, 12, 14) > 0.9);
    errors.push_back(run.ate(8, 14.5));
  }
  std::sort(errors.begin(), errors.end());
  CHECK(errors[errors.size() / 2] < 0.03);
}

TEST_CASE("semi_direct_vio: images with few features for a while") {
  struct Case {
    const char* name;
    RoomFlight::Change change;
    double end_s;  ///< from 8 s on
  };
  const auto blur = [](double t, cv::Mat& image, bool) {
    if (during(t, 8, 8.5)) cv::blur(image, image, {17, 17});
    return true;
  };
  const auto exposure = [](double t, cv::Mat& image, bool) {
    if (during(t, 8, 11) && std::lround(t * rate_hz) % 2 == 0) image *= 0.5;
    return true;
  };
  const auto object = [](double t, cv::Mat& image, bool) {  // a third of the width, moving to the right
    if (!during(t, 8, 11)) return true;
    const int left = int(60 * (t - 8)), width = image.cols * 3 / 10;
    for (int y = 0; y < image.rows; ++y) {
      for (int x = left; x < std::min(left + width, image.cols); ++x) {
        const int cell = ((x - left) / 16) * 7 + (y / 16) * 13;
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(60 + (cell * cell) % 130);
      }
    }
    return true;
  };
  const auto halved = [](double t, cv::Mat&, bool) { return t < 7 || std::lround(t * rate_hz) % 2 == 0; };
  const auto after_keyframe = [](double t, cv::Mat&, bool follows_keyframe) { return t < 7 || !follows_keyframe; };

  const Case each = GENERATE_COPY(Case{"blurred over 17 px", blur, 8.5}, Case{"exposure x 2", exposure, 11},
                                  Case{"a moving object", object, 11}, Case{"every second frame", halved, 14},
                                  Case{"no frame after a keyframe", after_keyframe, 14});
  const RoomFlight run(each.change);
  CAPTURE(each.name, run.ate(), run.ate(8, each.end_s), run.part(HealthState::tracking, 8, each.end_s),
          run.part(HealthState::tracking, 12, 14));
  CHECK(run.init.stage == InitStage::done);
  CHECK(run.ate() < rough_m);  // as without
  CHECK(run.ate(8, 14) < 0.03);
  CHECK(run.part(HealthState::lost, 0, 14) == 0);
  CHECK(run.part(HealthState::tracking, 12, 14) == 1);
}

// Its stationary pose was published, and it left during a visual outage before initialization was complete.
TEST_CASE("semi_direct_vio: the initial covariance after a reset is that of IMU-only propagation") {
  const double outage_s = GENERATE(1.5, 5.0);
  const RoomFlight run(
      [&](double t, cv::Mat& image, bool) {
        if (during(t, 1.5, 1.5 + outage_s)) image.setTo(0);
        return true;
      },
      is_stationary_first());
  CAPTURE(outage_s);
  SE3<double> T_published_true;  // the first pose that is published; the vertical is known
  bool has_pose = false;
  int poses_after = 0;
  for (const Estimate<double>& estimate : run.estimates) {
    const double t = run.time_of(estimate);
    const SE3<double> truth = run.T_world_body(t);
    has_pose = has_pose || estimate.health.state == HealthState::degraded;
    if (!has_pose) continue;
    if (T_published_true.p().isZero()) {
      const Mat<double, 3, 3> R = (estimate.T_world_body.rotation() * truth.rotation().inverse()).matrix();
      const SO3<double> yaw = SO3<double>::exp({0, 0, std::atan2(R(1, 0), R(0, 0))});
      T_published_true = SE3<double>(yaw, estimate.T_world_body.p() - yaw * truth.p());
    }
    const Vec<double, 6> error = minus(estimate.T_world_body, T_published_true * truth);
    CAPTURE(t, name_of(estimate.health.state), error.transpose(), estimate.covariance.diagonal().transpose());
    for (int k = 0; k < 6; ++k) CHECK(std::abs(error[k]) < 3 * std::sqrt(estimate.covariance(k, k)) + 2e-3);
    poses_after += t > 1.5 + outage_s && estimate.health.state != HealthState::initializing;
  }
  CHECK(poses_after > 10);
  CHECK(run.estimates.back().resets == (outage_s > 3));
}

TEST_CASE("semi_direct_vio: fifteen seconds of a real flight", "[data]") {
  const std::filesystem::path flight = std::filesystem::path(PLUMBLINE_TEST_DATA) / "euroc_mh01_flight";
  if (skip_without(flight)) return;
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
