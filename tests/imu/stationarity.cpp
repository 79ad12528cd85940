#include "plumbline/imu/stationarity.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs t_end = 2'000'000'000;

/// 2 s at 200 Hz: stationary in that attitude with biases, noise, and `disturb` on top.
template <class Disturb>
ImuBuffer<> resting(const Vec<double, 3>& bias_gyro, const Vec<double, 3>& accel, Disturb&& disturb) {
  testing::Gaussian normal(1);
  ImuBuffer<> buffer;
  for (TimeNs t = 0; t <= t_end; t += 5'000'000) {
    ImuSample s{t, bias_gyro + 2.4e-3 * normal.vector<3>(), accel + 2.8e-2 * normal.vector<3>()};
    disturb(static_cast<double>(t) * 1e-9, s);
    REQUIRE(buffer.add(s));
  }
  return buffer;
}

}  // namespace

TEST_CASE("stationarity: stationary, also under the vibration of rotors") {
  const Vec<double, 3> bias(0.01, -0.02, 0.07), up(0.6, 0, 0.8), accel = 9.86 * up;
  const StationarityReport quiet = stationarity(resting(bias, accel, [](double, ImuSample&) {}), t_end);
  REQUIRE(quiet.is_stationary());
  REQUIRE(quiet.blocks == 10);
  const StationarityReport rotors = stationarity(resting(bias, accel,
                                                         [](double t, ImuSample& s) {
                                                           s.gyro.x() += 0.1 * std::sin(2 * 3.14159 * 71 * t);
                                                           s.accel.z() += 2 * std::sin(2 * 3.14159 * 71 * t);
                                                         }),
                                                 t_end);
  REQUIRE(rotors.is_stationary());

  const NavState<double> x = stationary_state<double>(quiet);
  REQUIRE((x.bias_gyro - bias).norm() < 1e-3);  // 2.4e-3/sqrt(200) for each axis
  REQUIRE((x.bias_accel - 0.05 * up).norm() < 1e-2);
  REQUIRE((x.T_world_body.rotation() * up - Vec<double, 3>::UnitZ()).norm() < 1e-3);
  REQUIRE(std::abs(x.T_world_body.R()(1, 0)) < 1e-12);
  REQUIRE((x.v_world_body.norm() == 0 && x.T_world_body.p().norm() == 0));
  REQUIRE((minus(stationary_state<float>(quiet).cast<double>(), x).norm() < 1e-5));
}

TEST_CASE("stationarity: what excludes it") {
  const Vec<double, 3> bias(0.01, -0.02, 0.07), accel(0, 0, 9.81);
  const auto motion = [&](const Vec<double, 3>& b, const Vec<double, 3>& a, auto&& disturb) {
    return stationarity(resting(b, a, disturb), t_end).verdict;
  };
  const auto none = [](double, ImuSample&) {};
  REQUIRE(motion(bias, accel, [](double t, ImuSample& s) { s.gyro.y() += 0.05 * std::sin(4 * t); }) ==
          StationarityVerdict::rotating);
  REQUIRE(motion(bias, accel, [](double t, ImuSample& s) { s.accel.y() += 0.5 * std::sin(4 * t); }) ==
          StationarityVerdict::accelerating);
  REQUIRE(motion({0.3, 0, 0}, accel, none) == StationarityVerdict::implausible);
  REQUIRE(motion(bias, {0, 0, 10.5}, none) == StationarityVerdict::implausible);
  REQUIRE(stationarity(ImuBuffer<>(), t_end).verdict == StationarityVerdict::too_few_samples);
  REQUIRE(stationarity(resting(bias, accel, none), t_end + 500'000'000).verdict ==
          StationarityVerdict::too_few_samples);
  REQUIRE(stationarity(resting(bias, accel, none), 500'000'000).verdict == StationarityVerdict::too_few_samples);
  REQUIRE(stationarity(resting(bias, accel, none), t_end, {.gyro_spread = std::nan("")}).verdict ==
          StationarityVerdict::rotating);
}
