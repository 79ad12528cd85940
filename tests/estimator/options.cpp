// Options are reached by name, exist for what is there, and arrive where they are used.
#include "plumbline/estimator/options.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/initialization_points.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

constexpr int width = 160, height = 128;
using Camera = Pinhole<float>;
using MonoRig = Rig<Mono<Camera, width * height>>;
using MonoImuRig = Rig<Mono<Camera, width * height>, Imu>;
using RgbdRig = Rig<Rgbd<Camera, width * height>>;
using RgbdImuRig = Rig<Rgbd<Camera, width * height>, Imu>;

template <class Sensors, class FeatureSet = Features<Points<50>>>
using OptionsOf = EstimatorOptions<Composition<Sensors, FeatureSet, SlidingWindow<4>>>;

template <class O>
concept HasPoints = requires(O options) {
  options.points;
};
template <class O>
concept HasLines = requires(O options) {
  options.lines;
};
template <class O>
concept HasInitializationPoints = requires(O options) {
  options.initialization_points;
};
template <class O>
concept HasAlignment = requires(O options) {
  options.initialization.alignment;
};
template <class O>
concept HasTwoView = requires(O options) {
  options.initialization.two_view;
};
template <class O>
concept HasGravity = requires(O options) {
  options.propagation.gravity;
};

using Vo = Estimator<RgbdRig, Features<Points<50>>, SlidingWindow<4>>;

/// A camera that goes along a wall of gray squares, 2 m away.
class Run {
 public:
  explicit Run(const Vo::Options& options) {
    RgbdRig rig{};
    rig.vision.camera = {130, 130, 79.5f, 63.5f, {}};
    rig.vision.width = width;
    rig.vision.height = height;
    depth_.fill(2000);
    vo_ = std::make_unique<Vo>(rig, options);
  }
  /// The next frame, after `px` pixels of the image since the first one.
  Estimate<float> add(int px) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::uint32_t square = std::uint32_t((x + px) / 9) * 73856093u ^ std::uint32_t(y / 9) * 19349663u;
        gray_[std::size_t(y * width + x)] = std::uint8_t(30 + (square * 2654435761u >> 24) * 3 / 4);
      }
    }
    t_ns_ += 50'000'000;
    const Result<Estimate<float>> estimate =
        vo_->add_frame({t_ns_, {gray_.data(), width, height, width}, {depth_.data(), width, height, width}});
    REQUIRE(estimate);
    return *estimate;
  }
  /// How many of so many frames, 5 px apart, are keyframes.
  int keyframes(int frames) {
    int n = 0;
    for (int i = 0; i < frames; ++i) n += add(5 * i).keyframe;
    return n;
  }

 private:
  std::array<std::uint8_t, width * height> gray_;
  std::array<std::uint16_t, width * height> depth_;
  TimeNs t_ns_ = 0;
  std::unique_ptr<Vo> vo_;
};

}  // namespace

TEST_CASE("options: each kind's are there under its name, and no other's") {
  using OfPoints = OptionsOf<RgbdRig>;
  using OfLines = OptionsOf<RgbdRig, Features<Lines<50>>>;
  using OfBoth = OptionsOf<RgbdRig, Features<Points<50>, Lines<20>>>;
  using OfStart = OptionsOf<MonoImuRig, Features<InitializationPoints<50>, Lines<20>>>;
  STATIC_REQUIRE((HasPoints<OfPoints> && !HasLines<OfPoints> && !HasInitializationPoints<OfPoints>));
  STATIC_REQUIRE((!HasPoints<OfLines> && HasLines<OfLines> && !HasInitializationPoints<OfLines>));
  STATIC_REQUIRE((HasPoints<OfBoth> && HasLines<OfBoth> && !HasInitializationPoints<OfBoth>));
  STATIC_REQUIRE((!HasPoints<OfStart> && HasLines<OfStart> && HasInitializationPoints<OfStart>));

  OfBoth options;  // of the store and of the front end, side by side
  options.points.target_count = 7;
  options.points.max_misses = 3;
  options.lines.target_count = 9;
  REQUIRE((options.points.target_count == 7 && options.lines.target_count == 9));
  REQUIRE((options.points.max_misses == 3 && options.lines.max_misses == StoreOptions{}.max_misses));
}

TEST_CASE("options: those of the propagation and of the start follow the sensors") {
  STATIC_REQUIRE((!HasGravity<OptionsOf<MonoRig>> && HasGravity<OptionsOf<MonoImuRig>>));
  STATIC_REQUIRE((!HasAlignment<OptionsOf<MonoRig>> && HasTwoView<OptionsOf<MonoRig>>));
  STATIC_REQUIRE((HasAlignment<OptionsOf<MonoImuRig>> && HasTwoView<OptionsOf<MonoImuRig>>));
  STATIC_REQUIRE((HasAlignment<OptionsOf<RgbdImuRig>> && !HasTwoView<OptionsOf<RgbdImuRig>>));
  STATIC_REQUIRE((!HasAlignment<OptionsOf<RgbdRig>> && !HasTwoView<OptionsOf<RgbdRig>>));
}

TEST_CASE("options: defaults are those of a sensor class") {
  // Without depth keyframes come closest and overlap most, with depth and no IMU they come farthest apart.
  const KeyframeOptions mono = OptionsOf<MonoRig>{}.keyframe, mono_imu = OptionsOf<MonoImuRig>{}.keyframe,
                        rgbd = OptionsOf<RgbdRig>{}.keyframe, rgbd_imu = OptionsOf<RgbdImuRig>{}.keyframe;
  CHECK(mono.max_motion_rad == mono_imu.max_motion_rad);
  CHECK(mono.min_tracked_ratio == mono_imu.min_tracked_ratio);
  CHECK(rgbd.min_tracked_ratio == rgbd_imu.min_tracked_ratio);
  CHECK(mono.min_tracked_ratio > rgbd.min_tracked_ratio);
  CHECK(rgbd_imu.max_motion_rad > 1.2 * mono.max_motion_rad);
  CHECK(rgbd.max_motion_rad > 1.2 * rgbd_imu.max_motion_rad);
  // Without depth a reset comes after half as many frames.
  CHECK(2 * OptionsOf<MonoRig>{}.recovery.max_lost_frames == OptionsOf<RgbdRig>{}.recovery.max_lost_frames);
  CHECK(OptionsOf<MonoRig>{}.recovery.gap_s == OptionsOf<RgbdRig>{}.recovery.gap_s);
  // Beside an IMU a pixel weighs what it is worth; with depth more views must agree on where a point is.
  CHECK(OptionsOf<MonoImuRig>{}.points.sigma_px < OptionsOf<MonoRig>{}.points.sigma_px);
  CHECK(OptionsOf<RgbdImuRig>{}.points.sigma_px < OptionsOf<RgbdRig>{}.points.sigma_px);
  CHECK(OptionsOf<RgbdImuRig>{}.points.min_views > OptionsOf<MonoImuRig>{}.points.min_views);
  CHECK(OptionsOf<RgbdRig>{}.points.min_views == OptionsOf<MonoRig>{}.points.min_views);
}

TEST_CASE("options: of keyframes decide how often they come") {
  Vo::Options seldom, by_motion, by_overlap;
  seldom.keyframe = {.min_tracked_ratio = 0.1, .max_motion_rad = 1};
  by_motion.keyframe = {.min_tracked_ratio = 0.1, .max_motion_rad = 0.09};  // 12 px, of 5 px a frame
  by_overlap.keyframe = {.min_tracked_ratio = 2, .max_motion_rad = 1};
  CHECK(Run(seldom).keyframes(12) == 1);
  const int of_motion = Run(by_motion).keyframes(12);
  CHECK((of_motion >= 4 && of_motion <= 5));  // the first, and every third
  CHECK(Run(by_overlap).keyframes(12) == 12);
}

TEST_CASE("options: of the pose decide how few landmarks are an estimate") {
  Vo::Options options;
  Run usual(options);
  usual.add(0);
  REQUIRE(usual.add(5).health.state == HealthState::tracking);
  options.pose.min_inliers = 51;  // more than there can be
  Run strict(options);
  strict.add(0);
  const Estimate<float> estimate = strict.add(5);
  CHECK(estimate.health.state == HealthState::lost);
  CHECK(estimate.tracked == 0);
}

TEST_CASE("options: of the recovery decide when there is a reset") {
  for (const int max_lost_frames : {2, 6}) {
    Vo::Options options;
    options.recovery.max_lost_frames = max_lost_frames;
    Run run(options);
    run.add(0);
    run.add(5);
    for (int k = 1; k <= 8; ++k) {
      const Estimate<float> estimate = run.add(5000 + 1000 * k);  // another wall every time
      CAPTURE(max_lost_frames, k);
      if (k <= max_lost_frames) {
        REQUIRE(estimate.health.state == HealthState::lost);
        REQUIRE(estimate.resets == 0);
      } else if (k == max_lost_frames + 1) {
        REQUIRE(estimate.resets == 1);
      }
    }
  }
}

TEST_CASE("options: of the world frame and of the calibration are in the covariance") {
  Vo::Options options;
  options.calibration_error = 0;
  options.backend.sigma_first_position = 0.02;
  options.backend.sigma_first_rotation = 0.001;
  Run run(options);
  const Estimate<float> first = run.add(0);
  CHECK(std::sqrt(first.covariance(3, 3)) == Approx(0.02).epsilon(1e-3));
  CHECK(std::sqrt(first.covariance(0, 0)) == Approx(0.001).epsilon(1e-3));
  const auto variance_of_last = [](const Vo::Options& with) {
    Run far(with);
    Estimate<float> last;
    for (int i = 0; i < 8; ++i) last = far.add(5 * i);
    REQUIRE(last.T_world_body.p().norm() == Approx(2 * 35 / 130.0).epsilon(0.02));
    return double(last.covariance(3, 3));
  };
  const double without = variance_of_last(options);
  options.calibration_error = 0.1;
  CHECK(variance_of_last(options) - without == Approx(std::pow(0.1 * 2 * 35 / 130.0, 2)).epsilon(0.1));
}

TEST_CASE("options: arrive in the front end and in the recovery") {
  std::array<std::uint8_t, width * height> gray;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) gray[std::size_t(y * width + x)] = (x / 20 + y / 20) % 2 == 0 ? 40 : 200;
  }
  std::array<std::uint16_t, width * height> depth;
  depth.fill(2000);
  RgbdRig rig{};
  rig.vision.camera = {130, 130, 79.5f, 59.5f, {}};
  rig.vision.width = width;
  rig.vision.height = height;
  const Vo::Frame frame{1, {gray.data(), width, height, width}, {depth.data(), width, height, width}};

  Vo::Options options;
  options.points.target_count = 10;
  options.recovery.min_landmarks = 10;
  const auto few = std::make_unique<Vo>(rig, options);
  const Result<Estimate<float>> estimate = few->add_frame(frame);
  REQUIRE(estimate);
  REQUIRE(estimate->health.state != HealthState::initializing);
  REQUIRE(estimate->tracked == 10);
  REQUIRE(few->landmarks().get<0>().seen_count() == 10);

  options.recovery.min_landmarks = 11;
  const auto too_few = std::make_unique<Vo>(rig, options);
  REQUIRE(too_few->add_frame(frame)->health.state == HealthState::initializing);
}
