// Noise densities, random walks and vibration of simulated IMUs that are known.
#include "imu_noise.hpp"

#include <cmath>
#include <numbers>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/simulated_imu.hpp"
#include "vibration.hpp"

namespace pl = plumbline;
using Samples = std::vector<pl::ImuSample>;

namespace {

/// A trajectory of the simulated room that stops between two times.
Samples samples_of(const pl::testing::ImuQuality& quality, double stop_s, double go_s, double end_s,
                   std::uint64_t seed) {
  auto trajectory = pl::testing::Trajectory::for_scene("room", 1).value();
  if (stop_s < go_s) trajectory.stop(stop_s, go_s);
  pl::testing::SimulatedImu imu(quality, seed);
  Samples out;
  for (int i = 0; i < end_s * quality.noise.rate_hz; ++i) out.push_back(imu.next(trajectory).sample(0));
  return out;
}

/// At rest alone.
Samples at_rest(const pl::testing::ImuQuality& quality, double rest_s, std::uint64_t seed) {
  constexpr double after_s = 4;  // of the begin of the stop
  Samples out = samples_of(quality, 2, after_s + rest_s, after_s + rest_s, seed);
  out.erase(out.begin(), out.begin() + std::ptrdiff_t(after_s * quality.noise.rate_hz));
  return out;
}

const pl::testing::ImuQuality euroc, consumer{{1.0e-3, 1.0e-2, 1.0e-4, 5.0e-3, 200}, 0.02, 0.2};

bool is_within(double value, double factor, double truth) { return value > truth / factor && value < truth * factor; }

}  // namespace

TEST_CASE("The part at rest is found, and none in motion") {
  const std::uint64_t seed = GENERATE(range(1, 6));
  for (const auto& quality : {euroc, consumer}) {
    const Samples samples = samples_of(quality, 6, 14, 20, seed);
    const auto rest = find_rest(samples, {});
    REQUIRE(rest.size() == 1);
    const double begin_s = 1e-9 * double(samples[rest[0].begin].t_ns),
                 end_s = 1e-9 * double(samples[rest[0].end - 1].t_ns);
    CHECK(begin_s >= 6);
    CHECK(begin_s < 7.6);
    CHECK(end_s <= 14.01);
    CHECK(end_s > 12.4);
    CHECK(find_rest(samples_of(quality, 0, 0, 20, seed), {}).empty());
  }
}

TEST_CASE("Images that move tell that nothing is at rest") {
  const Samples samples = samples_of(euroc, 2, 12, 14, 1);
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < 280; ++i) {
    TrackedFrame frame{pl::TimeNs(i) * 50'000'000, i > 0, {}};
    for (std::uint32_t id = 0; id < 40; ++id) {
      const pl::Vec<double, 2> uv(100 + 10 * id + 0.8 * i, 200);
      frame.corners.push_back({id, uv, {0, 0, 1}, 0});
    }
    frames.push_back(frame);
  }
  REQUIRE(find_rest(samples, {}).size() == 1);
  CHECK(find_rest(samples, frames).empty());
  for (TrackedFrame& frame : frames)
    for (TrackedCorner& corner : frame.corners) corner.uv.x() = 100 + 10 * corner.id;
  CHECK(find_rest(samples, frames).size() == 1);
}

TEST_CASE("Densities of white noise are within their intervals, from three seconds on") {
  const double rest_s = GENERATE(3.5, 10, 60);
  for (const auto& quality : {euroc, consumer}) {
    int inside = 0, all = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Samples samples = at_rest(quality, rest_s, seed);
      const std::vector<SampleRange> rest{{0, samples.size()}};
      for (const auto& [sensor, density] : {std::pair{&pl::ImuSample::gyro, quality.noise.gyro_density},
                                            std::pair{&pl::ImuSample::accel, quality.noise.accel_density}}) {
        const auto found = estimate_noise(samples, sensor, rest);
        REQUIRE(found);
        CHECK(is_within(found->density.value, 1.5, density));
        inside += found->density.low < density && density < found->density.high;
        ++all;
      }
    }
    CHECK(inside >= 0.85 * all);  // of 95 %
  }
}

TEST_CASE("Random walks are within a factor of 1.5 of ten minutes, and bounded from above by ten seconds") {
  // One half of the differences at the longest times is walk.
  const pl::testing::ImuQuality quality{{1.7e-4, 2.0e-3, 2.0e-5, 2.0e-4, 200}, 0.01, 0.05};
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Samples samples = at_rest(quality, 600, seed);
    const auto gyro = estimate_noise(samples, &pl::ImuSample::gyro, {{0, samples.size()}}).value();
    const auto accel = estimate_noise(samples, &pl::ImuSample::accel, {{0, samples.size()}}).value();
    CHECK(is_within(gyro.walk.value, 1.5, quality.noise.gyro_walk));
    CHECK(is_within(accel.walk.value, 1.5, quality.noise.accel_walk));
    CHECK(is_within(gyro.density.value, 1.05, quality.noise.gyro_density));
    inside += gyro.walk.low < quality.noise.gyro_walk && quality.noise.gyro_walk < gyro.walk.high;
    inside += accel.walk.low < quality.noise.accel_walk && quality.noise.accel_walk < accel.walk.high;
    const auto brief = estimate_noise(samples, &pl::ImuSample::gyro, {{0, 2000}}).value();
    CHECK(brief.walk.high > quality.noise.gyro_walk);
  }
  CHECK(inside >= 16);  // of 20
}

TEST_CASE("What is no white noise with a random walk widens the interval") {
  Samples samples = at_rest(euroc, 10, 1);
  const std::vector<SampleRange> rest{{0, samples.size()}};
  const DensityEstimate before = estimate_noise(samples, &pl::ImuSample::accel, rest)->density;
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].accel.x() += 0.05 * std::sin(0.2 * double(i));
  const DensityEstimate after = estimate_noise(samples, &pl::ImuSample::accel, rest)->density;
  CHECK(after.high - after.low > 3 * (before.high - before.low));
}

TEST_CASE("No estimate from constant samples, from too few, from none") {
  Samples samples(1000);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = {pl::TimeNs(i) * 5'000'000, {0, 0, 0}, {0, 0, 9.81}};
  CHECK(!estimate_noise(samples, &pl::ImuSample::accel, {{0, samples.size()}}));
  const Samples noisy = at_rest(euroc, 10, 1);
  CHECK(!estimate_noise(noisy, &pl::ImuSample::accel, {{0, 10}}));
  CHECK(!estimate_noise(noisy, &pl::ImuSample::accel, {}));
  CHECK(find_rest({}, {}).empty());
  CHECK(!measure_vibration({}, &pl::ImuSample::accel, {}));
}

TEST_CASE("Vibration has its level and its frequency; white noise has its density and no frequency") {
  Samples samples = samples_of(euroc, 0, 0, 20, 3);
  const double noise_rms = std::sqrt(3 * (200 - 20)) * euroc.noise.accel_density;
  const auto quiet = measure_vibration(samples, &pl::ImuSample::accel, {{0, samples.size()}});
  REQUIRE(quiet);
  CHECK(is_within(quiet->rms, 1.1, noise_rms));
  CHECK(quiet->peak_hz == 0);
  CHECK(is_within(quiet->spectrum.density.back(), 1.3, euroc.noise.accel_density));
  const double hz = GENERATE(23.0, 61.0, 88.0);
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].accel.z() += 1.5 * std::sin(2 * std::numbers::pi * hz * 0.005 * double(i));
  const auto found = measure_vibration(samples, &pl::ImuSample::accel, {{0, samples.size()}});
  REQUIRE(found);
  CHECK(is_within(found->rms, 1.05, 1.5 / std::numbers::sqrt2));
  CHECK(std::abs(found->peak_hz - hz) < 0.8);
  // Of the second half, and of less than a window.
  const auto second = measure_vibration(samples, &pl::ImuSample::accel, complement_of({{0, 2000}}, samples.size()));
  REQUIRE(second);
  CHECK(is_within(second->rms, 1.05, 1.5 / std::numbers::sqrt2));
  CHECK(!measure_vibration(samples, &pl::ImuSample::accel, {{0, 250}}));
}

TEST_CASE("What is between parts") {
  const auto out = complement_of({{0, 10}, {20, 30}}, 40);
  REQUIRE(out.size() == 2);
  CHECK(out[0].begin == 10);
  CHECK(out[0].end == 20);
  CHECK(out[1].begin == 30);
  CHECK(out[1].end == 40);
  CHECK(complement_of({{0, 5}}, 5).empty());
}

TEST_CASE("Where something vibrates at rest, the density is bounded from above only") {
  Samples samples = at_rest(euroc, 20, 1);
  const std::vector<SampleRange> rest{{0, samples.size()}};
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].accel.x() += 0.2 * std::sin(2 * std::numbers::pi * 11.0 * 0.005 * double(i));
  const DensityEstimate found = estimate_noise(samples, &pl::ImuSample::accel, rest)->density;
  CHECK(found.low == 0);
  CHECK(found.high > euroc.noise.accel_density);
}
