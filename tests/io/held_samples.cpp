#include "plumbline/io/held_samples.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

/// 200 Hz, the accelerometer new in every `n`-th row.
std::vector<ImuSample> rows(int count, int n) {
  std::vector<ImuSample> out;
  for (int i = 0; i < count; ++i) {
    const double t = 0.005 * i, t_accel = 0.005 * (i - i % n);
    out.push_back({std::llround(1e9 * t), {std::sin(t), 0, 1}, {3 * t_accel, 0, 9.81}});
  }
  return out;
}

}  // namespace

TEST_CASE("held_samples: an accelerometer of 50 Hz in rows of 200 Hz") {
  std::vector<ImuSample> samples = rows(400, 4);
  const std::vector<ImuSample> before = samples;
  const HeldSensor held = interpolate_held(samples, &ImuSample::accel);
  REQUIRE((held.rate_hz == Approx(50) && held.scatter_density < 1e-9));
  for (std::size_t i = 0; i + 4 < samples.size(); ++i) {
    CAPTURE(i);
    REQUIRE(samples[i].accel.x() == Approx(3 * 0.005 * static_cast<double>(i)).margin(1e-12));
    REQUIRE(samples[i].gyro == before[i].gyro);
  }
  REQUIRE(interpolate_held(samples, &ImuSample::gyro).rate_hz == 0);
}

TEST_CASE("held_samples: what stays as it is") {
  std::vector<ImuSample> each = rows(400, 1), constant = rows(400, 1000), frozen = rows(400, 1), slow = rows(4000, 20);
  for (std::size_t i = 100; i < 200; ++i) frozen[i] = {frozen[i].t_ns, frozen[99].gyro, frozen[99].accel};
  for (std::vector<ImuSample>* samples : {&each, &constant, &frozen, &slow}) {
    const std::vector<ImuSample> before = *samples;
    REQUIRE(interpolate_held(*samples, &ImuSample::accel).rate_hz == 0);
    for (std::size_t i = 0; i < before.size(); ++i) REQUIRE((*samples)[i].accel == before[i].accel);
  }
  std::vector<ImuSample> few;
  REQUIRE(interpolate_held(few, &ImuSample::accel).rate_hz == 0);
}

TEST_CASE("held_samples: scatter of white noise") {
  std::vector<ImuSample> samples = rows(4000, 4);
  const double noise[4] = {0.3, -0.3, -0.3, 0.3};  // second differences: 0.6, 0.6 ...
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].accel.y() = noise[i / 4 % 4];
  // y: (0.6^2)/6 of one axis, a third of it on average, 50 Hz.
  REQUIRE(interpolate_held(samples, &ImuSample::accel).scatter_density ==
          Approx(std::sqrt(0.36 / 18 / 50)).epsilon(0.01));
}
