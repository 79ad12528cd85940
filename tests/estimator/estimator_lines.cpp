// The whole estimator with lines on rendered images: alone and beside points.
#include "allocation_counter.hpp"

#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

constexpr int frames = 60;
using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;
using OfLines = Estimator<Sensors, Features<Lines<100>>, SlidingWindow<6>>;
using OfBoth = Estimator<Sensors, Features<Points<250>, Lines<60>>, SlidingWindow<6>>;

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(frames);
  return simulated;
}

Sensors rig() {
  Sensors out{};
  out.vision.camera = room().camera;
  out.vision.width = SimulatedRgbd::width;
  out.vision.height = SimulatedRgbd::height;
  return out;
}

Sensors::Frame frame(int i) {
  const std::size_t k = std::size_t(i);
  return {room().t_ns[k], room().frames[k].gray.view(), room().frames[k].depth.view()};
}

/// Error of the motion since frame 0 [m].
double error_m(const Estimate<double>& estimate, int i) {
  const SE3<double> truth = room().T_world_cam[0].inverse() * room().T_world_cam[std::size_t(i)];
  return (estimate.T_world_body.p() - truth.p()).norm();
}

int lines_in_sight(const auto& vio) {
  int n = 0;
  vio.landmarks().for_each([&](const auto& store) {
    using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
    if constexpr (std::is_same_v<Kind, LineKind<Sensors>>) n += store.tracked_count();
  });
  return n;
}

}  // namespace

TEMPLATE_TEST_CASE("estimator_lines: follow a simulated room to centimeters, without heap", "", OfLines, OfBoth) {
  const auto vio = std::make_unique<TestType>(rig());
  double worst = 0, path = 0;
  room();
  for (int i = 0; i < frames; ++i) {
    const Sensors::Frame input = frame(i);
    Result<Estimate<double>> estimate = Error::late_sample;
    REQUIRE(test::allocations_of([&] { estimate = vio->add_frame(input); }) == 0);
    REQUIRE(estimate);
    CAPTURE(i);
    REQUIRE(estimate->health.state == HealthState::tracking);
    REQUIRE(lines_in_sight(*vio) >= 10);
    worst = std::max(worst, error_m(*estimate, i));
    if (i > 0) path += (room().T_world_cam[std::size_t(i)].p() - room().T_world_cam[std::size_t(i - 1)].p()).norm();
    const double sigma = std::sqrt(estimate->covariance.template bottomRightCorner<3, 3>().trace());
    if (i > 0) REQUIRE(error_m(*estimate, i) < 10 * sigma + 2e-3);
    REQUIRE(sigma < 0.1);
  }
  CAPTURE(path, worst);
  REQUIRE(path > 0.8);
  REQUIRE(worst < (std::is_same_v<TestType, OfLines> ? 0.05 : 0.03) * path);  // 320x240 pixels, noisy depth
}

TEST_CASE("estimator_lines: the same input gives the same output to the last bit") {
  const auto a = std::make_unique<OfBoth>(rig()), b = std::make_unique<OfBoth>(rig());
  for (int i = 0; i < 25; ++i) {
    const Result<Estimate<double>> x = a->add_frame(frame(i)), y = b->add_frame(frame(i));
    REQUIRE(x->T_world_body.p() == y->T_world_body.p());
    REQUIRE(x->T_world_body.rotation().quaternion().coeffs() == y->T_world_body.rotation().quaternion().coeffs());
    REQUIRE(x->covariance == y->covariance);
  }
}

TEST_CASE("estimator_lines: black frames are lost, frames without depth are used") {
  const auto vio = std::make_unique<OfLines>(rig());
  const testing::Image<std::uint8_t> black(SimulatedRgbd::width, SimulatedRgbd::height);
  for (int i = 0; i < 30; ++i) {
    Sensors::Frame input = frame(i);
    const bool is_black = i >= 10 && i < 13;
    if (is_black) input.gray = black.view();
    if (i % 3 == 1) input.depth = {};
    const Result<Estimate<double>> estimate = vio->add_frame(input);
    REQUIRE(estimate);
    REQUIRE((estimate->health.state == HealthState::lost) == is_black);
    REQUIRE(estimate->resets == 0);
    if (!is_black) REQUIRE(error_m(*estimate, i) < 0.03);
  }
}
