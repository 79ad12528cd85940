// Initialization of an estimator with an IMU that is shaken by hand from its first sample on.
#include "plumbline/initialization/inertial.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/io/trajectory_alignment.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/simulated_imu.hpp"

using namespace plumbline;

namespace {

constexpr int width = 320, height = 240;
using Camera = Pinhole<double>;
struct SteadyClock {
  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};

/// Six seconds at 20 Hz, with noise of image, depth and IMU, and biases.
struct VibratingRun {
  InitReport report;
  double start_s = 0;       ///< time that the frame took which finished the start
  double waiting_s = 0;     ///< the longest of a frame before
  double scale = 0;         ///< of all that was called tracking, against the truth: 1 is right
  double rms_m = 0;         ///< its error after alignment in position and heading
  std::size_t tracked = 0;  ///< frames called tracking
};

template <class Vision>
VibratingRun vibrating_run(std::uint64_t seed, double max_bias = InertialInitializerOptions{}.max_accel_bias_sigmas) {
  using Sensors = Rig<Vision, Imu>;
  using Vio = Estimator<Sensors, Features<Points<250>>, SlidingWindow<10>, SteadyClock>;
  const auto trajectory = testing::Trajectory::shaken(seed);
  const SE3<double> T_body_cam = testing::simulated_T_body_camera();
  const Camera camera{268, 268, 159.5, 119.5, {}};
  testing::SimulatedCamera simulated(testing::Renderer(*testing::make_scene("room"), camera, width, height, 2),
                                     T_body_cam, {}, seed);
  const testing::ImuQuality quality;
  testing::SimulatedImu simulated_imu(quality, seed);
  Sensors rig{};
  rig.vision.camera = camera;
  rig.vision.width = width;
  rig.vision.height = height;
  rig.imu.T_body_cam = T_body_cam;
  rig.imu.noise = quality.noise;
  typename Vio::Options options;
  options.initialization.max_accel_bias_sigmas = max_bias;
  const auto vio = std::make_unique<Vio>(rig, options);

  VibratingRun out;
  std::vector<io::PosePair> pairs;
  testing::SimulatedImu::Measurement measured = simulated_imu.next(trajectory);
  for (int k = 0; k < 120; ++k) {
    typename Vio::Frame frame;
    frame.t_ns = TimeNs(k) * 50'000'000;
    const double t = 1e-9 * double(frame.t_ns);
    for (; measured.t <= t + 0.006; measured = simulated_imu.next(trajectory))
      REQUIRE(vio->add_imu(measured.sample(0)));
    const testing::SimulatedCamera::Frame images = simulated.frame(trajectory, t, std::uint64_t(k));
    frame.gray = images.gray.view();
    if constexpr (Sensors::has_depth) frame.depth = images.depth.view();
    const bool was_done = vio->init_report().stage == InitStage::done;
    const Result<Estimate<double>> estimate = vio->add_frame(frame);
    REQUIRE(estimate);
    const bool is_done = vio->init_report().stage == InitStage::done;
    if (!is_done) out.waiting_s = std::max(out.waiting_s, vio->timing().total);
    if (is_done && !was_done) out.start_s = vio->timing().total;
    if (!is_done) {
      REQUIRE(estimate->health.state != HealthState::tracking);
      continue;
    }
    pairs.push_back({frame.t_ns, trajectory.at(t).T_world_body, estimate->T_world_body});
  }
  out.report = vio->init_report();
  out.tracked = pairs.size();
  if (const auto S = io::align(pairs, io::Alignment::sim3)) out.scale = 1 / S->scale();
  if (const auto S = io::align(pairs, io::Alignment::posyaw)) {
    for (const io::PosePair& pair : pairs)
      out.rms_m += (io::aligned(*S, pair.estimate).p() - pair.reference.p()).squaredNorm() / double(pairs.size());
    out.rms_m = std::sqrt(out.rms_m);
  }
  return out;
}

/// Either it initializes correctly, or it reports what it waits for.
void check(const VibratingRun& run) {
  CAPTURE(name_of(run.report.stage), name_of(run.report.alignment), run.report.rejected, run.tracked);
  CAPTURE(run.scale, run.rms_m, 1e3 * run.start_s, 1e3 * run.waiting_s);
  if (run.report.stage != InitStage::done) {
    REQUIRE(run.tracked == 0);
    REQUIRE((run.report.stage != InitStage::aligning || run.report.alignment != AlignmentOutcome::aligned));
  } else if (run.tracked > 20) {
    REQUIRE(std::abs(run.scale - 1) < 0.05);
    REQUIRE(run.rms_m < 0.03);
  }
}

void print(const char* sensors, std::vector<double> start_s) {
  std::sort(start_s.begin(), start_s.end());
  std::printf("%s: the frame that finishes the start takes %.1f ms (median), at most %.1f ms\n", sensors,
              1e3 * start_s[start_s.size() / 2], 1e3 * start_s.back());
}

}  // namespace

TEST_CASE("inertial_initializer: a camera without depth, shaken by hand from the first sample on") {
  std::vector<double> start_s;
  for (const std::uint64_t seed : {1, 2, 3, 5, 8, 14, 22, 29}) {
    CAPTURE(seed);
    const VibratingRun run = vibrating_run<Mono<Camera, width * height>>(seed);
    check(run);
    if (run.report.stage == InitStage::done) start_s.push_back(run.start_s);
  }
  REQUIRE(start_s.size() >= 5);
  print("mono-imu", start_s);
}

TEST_CASE("inertial_initializer: a camera with depth, shaken by hand from the first sample on") {
  std::vector<double> start_s;
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    const VibratingRun run = vibrating_run<Rgbd<Camera, width * height>>(seed);
    check(run);
    REQUIRE(1e-9 * double(run.report.done_ns) < 1);
    REQUIRE(run.tracked > 100);
    start_s.push_back(run.start_s);
  }
  print("rgbd-imu", start_s);
}

TEST_CASE("inertial_initializer: an alignment inconsistent with images and IMU together is rejected") {
  const VibratingRun run = vibrating_run<Mono<Camera, width * height>>(1, 0);
  REQUIRE((run.report.rejected > 0 && run.report.stage != InitStage::done && run.tracked == 0));
}

TEST_CASE("inertial_initializer: a time offset that varies is estimated twice, a stable one is accepted") {
  struct Rig {
    double offset_s;
    double time_offset_s() const { return offset_s; }
    Readout<double> readout() const { return {}; }
  };
  InertialInitializer<double, DepthInitializer<double>> start({});
  const auto found = [&](double aligned_by_s, double found_s) {
    start.add(0, SE3<double>(), zeros<double, 3, 3>(), Preintegration<double>(ImuNoise{}), Rig{aligned_by_s});
    return start.verify_time_offset(found_s);
  };
  const double wrong_s = 1.1 * start.options().max_time_error_s;
  CHECK_FALSE(found(0, wrong_s));
  CHECK(found(wrong_s, wrong_s));
  CHECK_FALSE(found(wrong_s, 0));
  CHECK_FALSE(found(0, wrong_s));
  CHECK(found(wrong_s, 0));
  CHECK_FALSE(found(0, wrong_s));
}
