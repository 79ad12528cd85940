// Options are reached by name, exist for what is there, and arrive where they are used.
#include "plumbline/estimator/options.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/feature/start_points.hpp"
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
concept HasStartPoints = requires(O options) {
  options.start_points;
};
template <class O>
concept HasAlignment = requires(O options) {
  options.start.alignment;
};
template <class O>
concept HasTwoView = requires(O options) {
  options.start.two_view;
};
template <class O>
concept HasGravity = requires(O options) {
  options.motion.gravity;
};

}  // namespace

TEST_CASE("options: each kind's are there under its name, and no other's") {
  using OfPoints = OptionsOf<RgbdRig>;
  using OfLines = OptionsOf<RgbdRig, Features<Lines<50>>>;
  using OfBoth = OptionsOf<RgbdRig, Features<Points<50>, Lines<20>>>;
  using OfStart = OptionsOf<MonoImuRig, Features<StartPoints<50>, Lines<20>>>;
  STATIC_REQUIRE((HasPoints<OfPoints> && !HasLines<OfPoints> && !HasStartPoints<OfPoints>));
  STATIC_REQUIRE((!HasPoints<OfLines> && HasLines<OfLines> && !HasStartPoints<OfLines>));
  STATIC_REQUIRE((HasPoints<OfBoth> && HasLines<OfBoth> && !HasStartPoints<OfBoth>));
  STATIC_REQUIRE((!HasPoints<OfStart> && HasLines<OfStart> && HasStartPoints<OfStart>));

  OfBoth options;  // of the store and of the front end, side by side
  options.points.target_count = 7;
  options.points.max_misses = 3;
  options.lines.target_count = 9;
  REQUIRE((options.points.target_count == 7 && options.lines.target_count == 9));
  REQUIRE((options.points.max_misses == 3 && options.lines.max_misses == StoreOptions{}.max_misses));
}

TEST_CASE("options: those of the motion and of the start follow the sensors") {
  STATIC_REQUIRE((!HasGravity<OptionsOf<MonoRig>> && HasGravity<OptionsOf<MonoImuRig>>));
  STATIC_REQUIRE((!HasAlignment<OptionsOf<MonoRig>> && HasTwoView<OptionsOf<MonoRig>>));
  STATIC_REQUIRE((HasAlignment<OptionsOf<MonoImuRig>> && HasTwoView<OptionsOf<MonoImuRig>>));
  STATIC_REQUIRE((HasAlignment<OptionsOf<RgbdImuRig>> && !HasTwoView<OptionsOf<RgbdImuRig>>));
  STATIC_REQUIRE((!HasAlignment<OptionsOf<RgbdRig>> && !HasTwoView<OptionsOf<RgbdRig>>));
}

TEST_CASE("options: keyframes come as often as the sensors need them") {
  REQUIRE(OptionsOf<MonoRig>{}.keyframe.max_motion_rad < OptionsOf<RgbdImuRig>{}.keyframe.max_motion_rad);
  REQUIRE(OptionsOf<RgbdImuRig>{}.keyframe.max_motion_rad < OptionsOf<RgbdRig>{}.keyframe.max_motion_rad);
  REQUIRE(OptionsOf<MonoImuRig>{}.keyframe.min_tracked_ratio > OptionsOf<RgbdImuRig>{}.keyframe.min_tracked_ratio);
}

TEST_CASE("options: a camera that begins by two views waits less long for a sight it knows") {
  REQUIRE(OptionsOf<MonoRig>{}.recovery.max_lost_frames < OptionsOf<RgbdRig>{}.recovery.max_lost_frames);
  REQUIRE(OptionsOf<MonoRig>{}.recovery.gap_s == OptionsOf<RgbdRig>{}.recovery.gap_s);
}

TEST_CASE("options: arrive in the front end and in the recovery") {
  using Vo = Estimator<RgbdRig, Features<Points<50>>, SlidingWindow<4>>;
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
