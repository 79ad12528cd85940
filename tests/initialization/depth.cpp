// A camera with depth: the first frame with enough depth is the initialization, one without waits.
#include "plumbline/initialization/depth.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

constexpr int width = 160, height = 128;
using Sensors = Rig<Rgbd<Pinhole<float>, width * height>>;
using Vo = Estimator<Sensors, Features<Points<50>>, SlidingWindow<4>>;

/// Gray squares, everywhere as far away as is said; 0: no depth.
struct Board {
  std::vector<std::uint8_t> gray = std::vector<std::uint8_t>(width * height);
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(width * height);
  TimeNs t_ns = 0;
  std::unique_ptr<Vo> vo;

  Board() {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::uint32_t square = std::uint32_t(x / 12) * 73856093u ^ std::uint32_t(y / 12) * 19349663u;
        gray[std::size_t(y * width + x)] = std::uint8_t(30 + (square * 2654435761u >> 24) * 3 / 4);
      }
    }
    Sensors rig{};
    rig.vision.camera = {130, 130, 79.5f, 63.5f, {}};
    rig.vision.width = width;
    rig.vision.height = height;
    vo = std::make_unique<Vo>(rig);
  }
  /// The left part of the image, `columns` wide, has depth.
  Estimate<float> add(std::uint16_t depth_mm, int columns = width) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) depth[std::size_t(y * width + x)] = x < columns ? depth_mm : 0;
    }
    return add({depth.data(), width, height, width});
  }
  Estimate<float> add(const ImageView<const std::uint16_t>& view) {
    t_ns += 50'000'000;
    const Result<Estimate<float>> estimate = vo->add_frame({t_ns, {gray.data(), width, height, width}, view});
    REQUIRE(estimate);
    return *estimate;
  }
};

}  // namespace

TEST_CASE("depth: one frame with depth is enough, and places its landmarks in meters") {
  const int depth_mm = GENERATE(1000, 2500);
  Board board;
  const Estimate<float> estimate = board.add(std::uint16_t(depth_mm));
  CHECK(estimate.health.state == HealthState::tracking);
  CHECK(estimate.keyframe);
  CHECK(estimate.T_world_body.p().norm() == 0);
  REQUIRE(estimate.tracked >= RecoveryOptions{}.min_landmarks);
  REQUIRE(estimate.tracked == board.vo->landmarks().seen_count());
  for (const auto& landmark : board.vo->landmarks().get<0>().landmarks()) {
    REQUIRE(landmark.located);
    const float z = landmark.geometry.bearing.z() / landmark.geometry.inverse_range;
    REQUIRE(z == Approx(1e-3 * depth_mm).epsilon(1e-4));
  }
  REQUIRE(board.add(std::uint16_t(depth_mm)).health.state != HealthState::initializing);
}

TEST_CASE("depth: frames without depth start nothing, whatever they show, and say what is missing") {
  Board board;
  for (int k = 0; k < 5; ++k) {
    const Estimate<float> estimate = k % 2 == 0 ? board.add(0) : board.add(ImageView<const std::uint16_t>());
    CAPTURE(k);
    REQUIRE(estimate.health.state == HealthState::initializing);
    REQUIRE(estimate.health.reason == HealthReason::no_depth);
    REQUIRE(estimate.tracked == 0);
  }
  // Depth beyond the sensor's range is none.
  REQUIRE(board.add(20000).health.state == HealthState::initializing);
  const Estimate<float> estimate = board.add(2000);
  REQUIRE(estimate.health.state == HealthState::tracking);
  REQUIRE(estimate.resets == 0);
}

TEST_CASE("depth: corners with depth count, the others do not") {
  Board board;
  const Estimate<float> few = board.add(2000, width / 4);
  const int with_depth = board.vo->landmarks().tracked_count(), all = board.vo->landmarks().seen_count();
  CAPTURE(with_depth, all);
  REQUIRE((with_depth > 0 && with_depth < RecoveryOptions{}.min_landmarks));
  REQUIRE(all >= RecoveryOptions{}.min_landmarks);
  CHECK(few.health.state == HealthState::initializing);
  CHECK(few.health.reason == HealthReason::no_depth);
  CHECK(board.add(2000).health.state == HealthState::tracking);
}

TEMPLATE_TEST_CASE("depth: nothing is kept", "", float, double) {
  using Initializer = DepthInitializer<TestType>;
  STATIC_REQUIRE(!Initializer::needs_second_view);
  STATIC_REQUIRE(std::is_empty_v<Initializer>);
  STATIC_REQUIRE(std::is_empty_v<typename Initializer::Options>);
  Initializer initializer({});
  REQUIRE(&initializer.visual() == &initializer);
}
