#include "plumbline/initialization/stop_detector.hpp"

#include "catch.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial_options.hpp"

using namespace plumbline;

namespace {
constexpr TimeNs ms = 1'000'000;
}

TEST_CASE("stop_detector: a body stops when its tracks keep their length for the time of observation") {
  const InertialOptions options{};
  StopDetector stop(options);
  const double moving = 2 * options.stationary_motion_px, noise = 0.9 * options.stationary_motion_px;
  TimeNs t_ns = 0;
  for (int k = 1; k <= 20; ++k) CHECK_FALSE(stop.has_stopped(t_ns += 50 * ms, k * moving));
  const TimeNs stopped_ns = t_ns;
  for (int k = 0; seconds_between(stopped_ns, t_ns + 50 * ms) <= options.stationary_check_s; ++k)
    CHECK_FALSE(stop.has_stopped(t_ns += 50 * ms, 20 * moving + (k % 2) * noise));
  CHECK(stop.has_stopped(t_ns += 50 * ms, 20 * moving));
  CHECK_FALSE(stop.has_stopped(t_ns += 50 * ms, 21 * moving));
}

TEST_CASE("stop_detector: tracks of a stationary body drift beyond the limit of motion") {
  const InertialOptions options{};
  const StopDetector stop(options);
  CHECK_FALSE(stop.has_drifted(0.9 * options.stationary_motion_px));
  CHECK(stop.has_drifted(1.1 * options.stationary_motion_px));
}

TEST_CASE("stop_detector: without an IMU nothing keeps still") {
  StopDetector stop(ConstantVelocityOptions{});
  for (int k = 0; k < 3; ++k) CHECK_FALSE(stop.has_stopped(k * 50 * ms, 0));
}
