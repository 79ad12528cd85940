// The whole estimator on rendered images: accuracy against exact truth, determinism, bad input, recovery, no heap.
#include "allocation_counter.hpp"

#include "plumbline/estimator/estimator.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

using Sensors = Rig<Rgbd<Pinhole<double>, SimulatedRgbd::width * SimulatedRgbd::height>>;
using Vio = Estimator<Sensors, Features<Points<250>>, SlidingWindow<6>>;

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(60);
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

}  // namespace

TEST_CASE("estimator: follows a simulated room to centimeters, without heap") {
  const auto vio = std::make_unique<Vio>(rig());
  double worst = 0, path = 0;
  room();
  for (int i = 0; i < 60; ++i) {
    const Sensors::Frame input = frame(i);
    Result<Estimate<double>> estimate = Error::late_sample;
    REQUIRE(test::allocations_of([&] { estimate = vio->add_frame(input); }) == 0);
    REQUIRE(estimate);
    REQUIRE(estimate->health.state == HealthState::tracking);
    REQUIRE(estimate->T_world_body.is_finite());
    worst = std::max(worst, error_m(*estimate, i));
    if (i > 0) path += (room().T_world_cam[std::size_t(i)].p() - room().T_world_cam[std::size_t(i - 1)].p()).norm();
  }
  CAPTURE(path, worst);
  REQUIRE(path > 0.8);
  REQUIRE(worst < 0.03 * path);  // 320x240 pixels, noisy depth
}

TEST_CASE("estimator: the same input gives the same output to the last bit") {
  const auto a = std::make_unique<Vio>(rig()), b = std::make_unique<Vio>(rig());
  for (int i = 0; i < 25; ++i) {
    const Result<Estimate<double>> x = a->add_frame(frame(i)), y = b->add_frame(frame(i));
    REQUIRE(x->T_world_body.p() == y->T_world_body.p());
    REQUIRE(x->T_world_body.rotation().quaternion().coeffs() == y->T_world_body.rotation().quaternion().coeffs());
    REQUIRE(x->covariance == y->covariance);
  }
}

TEST_CASE("estimator: bad input is named and changes nothing") {
  const auto vio = std::make_unique<Vio>(rig());
  REQUIRE(vio->add_frame(frame(0)));
  REQUIRE(vio->add_frame(frame(1)));
  REQUIRE(vio->add_frame(frame(1)).error() == Error::late_sample);
  REQUIRE(vio->add_frame(frame(0)).error() == Error::late_sample);
  Sensors::Frame wrong = frame(2);
  wrong.gray.width -= 1;
  REQUIRE(vio->add_frame(wrong).error() == Error::wrong_image_size);
  wrong = frame(2);
  wrong.depth.height -= 1;
  REQUIRE(vio->add_frame(wrong).error() == Error::wrong_image_size);
  const Result<Estimate<double>> estimate = vio->add_frame(frame(2));
  REQUIRE(estimate);
  REQUIRE(error_m(*estimate, 2) < 0.01);
}

TEST_CASE("estimator: does not start on a black image, says why, and starts on the next good one") {
  const auto vio = std::make_unique<Vio>(rig());
  const testing::Image<std::uint8_t> black(SimulatedRgbd::width, SimulatedRgbd::height);
  Sensors::Frame dark = frame(0);
  dark.gray = black.view();
  const Result<Estimate<double>> none = vio->add_frame(dark);
  REQUIRE(none->health.state == HealthState::initializing);
  REQUIRE(none->health.reason == HealthReason::few_features);
  REQUIRE(vio->add_frame(frame(1))->health.state == HealthState::tracking);
}

TEST_CASE("estimator: black frames are lost, and tracking continues at the pose before them") {
  const auto vio = std::make_unique<Vio>(rig());
  const testing::Image<std::uint8_t> black(SimulatedRgbd::width, SimulatedRgbd::height);
  for (int i = 0; i < 30; ++i) {
    Sensors::Frame input = frame(i);
    const bool is_black = i >= 10 && i < 15;
    if (is_black) input.gray = black.view();
    const Result<Estimate<double>> estimate = vio->add_frame(input);
    REQUIRE(estimate);
    REQUIRE((estimate->health.state == HealthState::lost) == is_black);
    REQUIRE(estimate->resets == 0);
    if (!is_black) REQUIRE(error_m(*estimate, i) < 0.03);
  }
}

TEST_CASE("estimator: a camera without an IMU tracks again after a visual outage of 0.6 s") {
  const auto vio = std::make_unique<Vio>(rig());
  const testing::Image<std::uint8_t> black(SimulatedRgbd::width, SimulatedRgbd::height);
  const bool images_come = GENERATE(true, false);
  const int first = GENERATE(4, 10, 14, 18), last = first + 11;  // while it moves by 0.2 to 0.25 m
  for (int i = 0; i < 60; ++i) {
    const bool is_black = i >= first && i <= last;
    Sensors::Frame input = frame(i);
    if (is_black && !images_come) continue;
    if (is_black) input.gray = black.view();
    const Result<Estimate<double>> estimate = vio->add_frame(input);
    REQUIRE(estimate);
    CAPTURE(i, error_m(*estimate, i));
    REQUIRE(estimate->resets == 0);
    REQUIRE((estimate->health.state == HealthState::lost) == is_black);
    if (is_black) {  // it may have gone anywhere
      const double outage_s = (i - first + 1) / 20.0, sigma = std::sqrt(estimate->covariance(3, 3));
      REQUIRE(sigma == Approx(RecoveryOptions{}.lost_speed * outage_s).epsilon(0.01));
    } else {
      REQUIRE(error_m(*estimate, i) < 0.05);
    }
  }
}

TEST_CASE("estimator: a repeated image is no measurement, and does no harm") {
  const auto vio = std::make_unique<Vio>(rig());
  for (int i = 0; i < 60; ++i) {
    const bool repeats = i >= 10 && i < 22;
    Sensors::Frame input = frame(repeats ? 9 : i);
    input.t_ns = frame(i).t_ns;
    const Result<Estimate<double>> estimate = vio->add_frame(input);
    REQUIRE(estimate);
    CAPTURE(i, error_m(*estimate, i));
    REQUIRE(estimate->resets == 0);
    REQUIRE((estimate->health.reason == HealthReason::images_repeat) == repeats);
    REQUIRE(estimate->health.state == (repeats ? HealthState::degraded : HealthState::tracking));
    if (!repeats) REQUIRE(error_m(*estimate, i) < 0.05);
    if (repeats) REQUIRE(error_m(*estimate, i) < 3 * std::sqrt(estimate->covariance(3, 3)));
  }
}

TEST_CASE(
    "estimator: a camera that repeats its image is lost after a while, and there is a reset at the next new image") {
  const auto vio = std::make_unique<Vio>(rig());
  for (int i = 0; i < 10; ++i) REQUIRE(vio->add_frame(frame(i)));
  const double max_imu_only_s = RecoveryOptions{}.max_imu_only_s;
  for (int i = 1; i <= 100; ++i) {  // 5 s
    Sensors::Frame again = frame(9);
    again.t_ns += i * TimeNs(50'000'000);
    const Result<Estimate<double>> estimate = vio->add_frame(again);
    CAPTURE(i);
    REQUIRE(estimate->health.reason == HealthReason::images_repeat);
    REQUIRE(estimate->health.state == (0.05 * i < max_imu_only_s ? HealthState::degraded : HealthState::lost));
    REQUIRE(estimate->resets == 0);
  }
  Sensors::Frame input = frame(50);
  input.t_ns = frame(9).t_ns + TimeNs(5'050'000'000);
  const Result<Estimate<double>> estimate = vio->add_frame(input);
  REQUIRE(estimate->health.state == HealthState::tracking);
  REQUIRE(estimate->resets == 1);
}

TEST_CASE("estimator: after an outage that is too long there is a reset, as uncertain as the outage was long") {
  const auto vio = std::make_unique<Vio>(rig());
  const testing::Image<std::uint8_t> black(SimulatedRgbd::width, SimulatedRgbd::height);
  for (int i = 0; i < 10; ++i) REQUIRE(vio->add_frame(frame(i)));
  for (int i = 0; i < 100; ++i) {  // 5 s
    Sensors::Frame dark = frame(9);
    dark.gray = black.view();
    dark.t_ns += (i + 1) * TimeNs(50'000'000);
    REQUIRE(vio->add_frame(dark)->health.state == HealthState::lost);
  }
  Sensors::Frame input = frame(50);
  input.t_ns = frame(9).t_ns + TimeNs(5'050'000'000);
  const Result<Estimate<double>> estimate = vio->add_frame(input);
  REQUIRE(estimate->health.state == HealthState::tracking);
  REQUIRE(estimate->resets == 1);
  REQUIRE(std::sqrt(estimate->covariance(3, 3)) == Approx(5.05 * RecoveryOptions{}.lost_speed).epsilon(0.01));
}

TEST_CASE("estimator: a frame without depth is used as one of a gray camera") {
  const auto vio = std::make_unique<Vio>(rig());
  for (int i = 0; i < 30; ++i) {
    Sensors::Frame input = frame(i);
    if (i % 3 == 1) input.depth = {};
    const Result<Estimate<double>> estimate = vio->add_frame(input);
    REQUIRE(estimate);
    REQUIRE(error_m(*estimate, i) < 0.03);
  }
}

TEST_CASE("estimator: the covariance is that of the errors, over five paths") {
  // Mean NEES of position and rotation, three degrees of freedom each, over five paths through the room.
  constexpr int seeds = 5, frames = 40, first = 5;
  double nees_position = 0, nees_rotation = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const SimulatedRgbd world(frames, 2, 20, *testing::Trajectory::for_scene("room", std::uint64_t(seed)));
    Vio::Options options;  // errors are those since frame 0, so the covariance must be, too
    options.backend.sigma_first_position = options.backend.sigma_first_rotation = 1e-6;
    options.calibration_error = 0;
    const auto vio = std::make_unique<Vio>(rig(), options);
    double position = 0, rotation = 0;
    for (int i = 0; i < frames; ++i) {
      const std::size_t k = std::size_t(i);
      const Result<Estimate<double>> estimate =
          vio->add_frame({world.t_ns[k], world.frames[k].gray.view(), world.frames[k].depth.view()});
      REQUIRE(estimate);
      const Mat<double, 6, 6>& P = estimate->covariance;
      REQUIRE(Eigen::SelfAdjointEigenSolver<Mat<double, 6, 6>>(P).eigenvalues().minCoeff() > 0);
      if (i < first) continue;
      const Vec<double, 6> e = minus(world.T_world_cam[0].inverse() * world.T_world_cam[k], estimate->T_world_body);
      const auto nees = [&](int at) {
        const Vec<double, 3> d = e.segment<3>(at);
        return d.dot(P.block<3, 3>(at, at).inverse() * d);
      };
      rotation += nees(0) / (frames - first);
      position += nees(3) / (frames - first);
    }
    nees_position += position / seeds;
    nees_rotation += rotation / seeds;
  }
  CAPTURE(nees_position, nees_rotation);
  // Of three degrees of freedom 3 is expected. Measured are 0.73 and 0.64: the covariance is safe, its sigmas are twice
  // those of the errors. The bounds are a factor of 1.5 beside that.
  CHECK(nees_position > 0.48);
  CHECK(nees_position < 1.1);
  CHECK(nees_rotation > 0.42);
  CHECK(nees_rotation < 0.96);
}

TEST_CASE("estimator: a mask leaves out what stands still in the image, without heap; an empty one is none") {
  constexpr int width = SimulatedRgbd::width, height = SimulatedRgbd::height;
  const auto is_bonnet = [](int y) { return y >= 3 * height / 4; };
  testing::Image<std::uint8_t> used(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) used.view()(x, y) = is_bonnet(y) ? 0 : 255;
  }
  const auto vio = std::make_unique<Vio>(rig()), unmasked = std::make_unique<Vio>(rig());
  REQUIRE(vio->set_mask({used.view().data, width, height - 1, width}).error() == Error::wrong_image_size);
  REQUIRE(*vio->set_mask(used.view()));
  REQUIRE(*unmasked->set_mask(used.view()));
  REQUIRE_FALSE(*unmasked->set_mask({}));
  const auto reference = std::make_unique<Vio>(rig());
  double worst = 0, path = 0;
  for (int i = 0; i < 40; ++i) {
    const Sensors::Frame input = frame(i);
    testing::Image<std::uint8_t> image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool is_bright = (x / 9 + y / 9) % 2 == 0;
        image.view()(x, y) = is_bonnet(y) ? std::uint8_t(is_bright ? 220 : 30) : input.gray(x, y);
      }
    }
    Sensors::Frame covered = input;
    covered.gray = image.view();
    Result<Estimate<double>> estimate = Error::late_sample;
    REQUIRE(test::allocations_of([&] { estimate = vio->add_frame(covered); }) == 0);
    REQUIRE(estimate);
    REQUIRE(estimate->health.state == HealthState::tracking);
    for (const auto& landmark : vio->landmarks().get<0>().landmarks()) {
      if (landmark.current.valid) REQUIRE(landmark.current.pixel.y() < 3 * height / 4 - 8);
    }
    worst = std::max(worst, error_m(*estimate, i));
    if (i > 0) path += (room().T_world_cam[std::size_t(i)].p() - room().T_world_cam[std::size_t(i - 1)].p()).norm();
    REQUIRE(unmasked->add_frame(input)->T_world_body.p() == reference->add_frame(input)->T_world_body.p());
  }
  CAPTURE(path, worst);
  REQUIRE(worst < 0.03 * path);
}
