#include "plumbline/imu/imu_buffer.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs ms = 1'000'000, t0 = 1'400'000'000'000'000'000;

/// Samples that are linear in time: w = (t, 2 t, 0), a = (0, t, 9.81), t in seconds from t0.
ImuSample linear(TimeNs t_ns) {
  const double t = seconds_between(t0, t_ns);
  return {t_ns, {t, 2 * t, 0}, {0, t, 9.81}};
}

struct Extracted {
  ImuCoverage coverage;
  std::vector<ImuInterval<double>> intervals;
};

template <class Buffer>
Extracted extract(const Buffer& buffer, TimeNs begin, TimeNs end) {
  Extracted out;
  out.coverage =
      buffer.for_each_interval(begin, end, [&](const ImuInterval<double>& i) { out.intervals.push_back(i); });
  REQUIRE(out.coverage.intervals == int(out.intervals.size()));
  double sum = 0;
  for (const ImuInterval<double>& i : out.intervals) {
    REQUIRE(i.dt > 0);
    sum += i.dt;
  }
  if (out.coverage.valid) REQUIRE(sum == Approx(seconds_between(begin, end)).epsilon(1e-12));
  return out;
}

/// Samples at 0, 5, 10, ... ms but for those in a gap.
ImuBuffer<64> filled(TimeNs until, TimeNs gap_begin = 0, TimeNs gap_end = 0) {
  ImuBuffer<64> buffer;
  for (TimeNs t = 0; t <= until; t += 5 * ms)
    if (!(t > gap_begin && t < gap_end)) REQUIRE(buffer.add(linear(t0 + t)));
  return buffer;
}

}  // namespace

TEST_CASE("imu_buffer: between two times, cut by interpolation at both ends") {
  const ImuBuffer<64> buffer = filled(100 * ms);
  const TimeNs begin = t0 + 12 * ms, end = t0 + 28 * ms;
  const Extracted e = extract(buffer, begin, end);
  REQUIRE(e.intervals.size() == 4);  // 12 - 15 - 20 - 25 - 28
  REQUIRE((e.coverage.valid && e.coverage.missing() == 0 && e.coverage.saturated_s == 0));
  TimeNs t = begin;
  for (const ImuInterval<double>& i : e.intervals) {
    REQUIRE((i.gyro_begin - linear(t).gyro).norm() + (i.accel_begin - linear(t).accel).norm() < 1e-12);
    t += TimeNs(i.dt * 1e9 + 0.5);
    REQUIRE((i.gyro_end - linear(t).gyro).norm() + (i.accel_end - linear(t).accel).norm() < 1e-12);
    REQUIRE((i.gyro_sigma == 0 && i.accel_sigma.norm() < 1e-9));
  }
  REQUIRE(t == end);
}

TEST_CASE("imu_buffer: exactly at samples, within one interval, consecutive parts") {
  const ImuBuffer<64> buffer = filled(100 * ms);
  REQUIRE(extract(buffer, t0 + 10 * ms, t0 + 20 * ms).intervals.size() == 2);
  REQUIRE(extract(buffer, t0 + 11 * ms, t0 + 13 * ms).intervals.size() == 1);
  REQUIRE(extract(buffer, t0, t0 + 100 * ms).intervals.size() == 20);
  REQUIRE(extract(buffer, t0, t0 + 100 * ms).coverage.held_s == 0);
  REQUIRE((buffer.reaches(t0 + 100 * ms) && !buffer.reaches(t0 + 100 * ms + 1)));
}

TEST_CASE("imu_buffer: nothing to give") {
  REQUIRE(!extract(ImuBuffer<8>(), t0, t0 + ms).coverage.valid);
  REQUIRE(ImuBuffer<8>().for_each_interval(t0, t0 + ms, [](const auto&) {}).missing() == 1);
  const ImuBuffer<64> buffer = filled(100 * ms);
  REQUIRE(!extract(buffer, t0 + ms, t0 + ms).coverage.valid);
  REQUIRE(!extract(buffer, t0 + 2 * ms, t0 + ms).coverage.valid);
}

TEST_CASE("imu_buffer: rejects NaN and repeated times, and continues") {
  ImuBuffer<64> buffer = filled(10 * ms);
  ImuSample bad = linear(t0 + 15 * ms);
  bad.accel.y() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(buffer.add(bad).error() == Error::not_finite);
  bad.accel.y() = std::numeric_limits<double>::infinity();
  REQUIRE(buffer.add(bad).error() == Error::not_finite);
  REQUIRE(buffer.add(linear(t0 + 10 * ms)).error() == Error::late_sample);
  REQUIRE(buffer.add(linear(t0 + 5 * ms)).error() == Error::late_sample);
  REQUIRE(buffer.add(linear(t0 + 15 * ms)));
  REQUIRE((buffer.counts().accepted == 4 && buffer.counts().repeated == 2 && buffer.counts().not_finite == 2));
  REQUIRE((buffer.counts().late == 0 && buffer.counts().reordered == 0));
  REQUIRE(extract(buffer, t0, t0 + 15 * ms).intervals.size() == 3);
}

TEST_CASE("imu_buffer: samples in any order between two frames are those in order") {
  Random random(3);
  ImuBufferOptions options;
  options.frozen_samples = 4;
  ImuBuffer<64> in_order(options), shuffled(options);
  constexpr int n = 200, together = 5;  // more than the buffer holds
  std::vector<ImuSample> samples;
  for (int k = 0; k < n; ++k) {
    samples.push_back({t0 + k * 5 * ms, {random.uniform(), 0, 0}, {0, 0, random.uniform()}});
    if (k % 20 > 10) samples.back() = {samples.back().t_ns, samples[k - 1].gyro, samples[k - 1].accel};  // frozen
  }
  for (int k = 0; k < n; k += together) {
    std::vector<ImuSample> some(samples.begin() + k, samples.begin() + k + together);
    for (const ImuSample& s : some) REQUIRE(in_order.add(s));
    for (std::uint32_t i = together; i > 1; --i) std::swap(some[i - 1], some[random.below(i)]);
    for (const ImuSample& s : some) REQUIRE(shuffled.add(s));
    if (k < 2 * together) continue;
    const TimeNs end = samples[k].t_ns + 2 * ms, begin = end - 25 * ms;
    const Extracted a = extract(in_order, begin, end), b = extract(shuffled, begin, end);
    in_order.mark_used(end);
    shuffled.mark_used(end);
    REQUIRE((a.intervals.size() == b.intervals.size() && a.coverage.frozen_s == b.coverage.frozen_s));
    for (std::size_t i = 0; i < a.intervals.size(); ++i) {
      const ImuInterval<double>&x = a.intervals[i], &y = b.intervals[i];
      REQUIRE((x.dt == y.dt && x.gyro_begin == y.gyro_begin && x.accel_end == y.accel_end));
      REQUIRE((x.gyro_sigma == y.gyro_sigma && x.accel_sigma == y.accel_sigma));
    }
  }
  REQUIRE(shuffled.counts().reordered > n / 4);
  REQUIRE((shuffled.counts().accepted == n && shuffled.counts().late == 0 && in_order.counts().reordered == 0));
}

TEST_CASE("imu_buffer: what comes after the frame that needed it is late") {
  ImuBuffer<64> buffer = filled(20 * ms);
  buffer.mark_used(t0 + 17 * ms);
  REQUIRE(buffer.add(linear(t0 + 16 * ms)).error() == Error::late_sample);
  REQUIRE(buffer.add(linear(t0 + 17 * ms)).error() == Error::late_sample);
  REQUIRE(buffer.add(linear(t0 + 18 * ms)));
  REQUIRE((buffer.counts().late == 2 && buffer.counts().reordered == 1 && buffer.size() == 6));
  buffer.mark_used(t0 + 30 * ms);  // a frame that did not wait: in order they still serve the next one
  REQUIRE(buffer.add(linear(t0 + 25 * ms)));
  REQUIRE((buffer.counts().late == 3 && buffer.size() == 7));
  REQUIRE(buffer.add(linear(t0 - 5000 * ms))->clock_jumped);  // the clock was set back; no sample of it was used
  REQUIRE((buffer.add(linear(t0 - 5001 * ms)) && buffer.counts().late == 3));

  ImuBuffer<4> small;
  for (int k = 1; k <= 4; ++k) REQUIRE(small.add(linear(t0 + k * 5 * ms)));
  REQUIRE(small.add(linear(t0)).error() == Error::late_sample);  // older than all that there is room for
  REQUIRE((small.add(linear(t0 + 6 * ms)) && small.size() == 4 && small[0].t_ns == t0 + 6 * ms));
}

TEST_CASE("imu_buffer: a jump of the time stamps clears the buffer, also after absurd ones") {
  for (const TimeNs jump : {TimeNs(2'000) * ms, -TimeNs(5'000) * ms, t0, -3 * t0}) {
    ImuBuffer<64> buffer = filled(10 * ms);
    const TimeNs t = t0 + jump;
    const auto accepted = buffer.add({t, {0, 0, 0}, {0, 0, 9.81}});
    REQUIRE((accepted && accepted->clock_jumped && buffer.size() == 1));
    REQUIRE(buffer.add(linear(t0 + 20 * ms))->clock_jumped);  // and back
    REQUIRE(buffer.add(linear(t0 + 25 * ms)));
    REQUIRE((buffer.size() == 2 && buffer.counts().clock_jumps == 2));
    for (const TimeNs impossible : {std::numeric_limits<TimeNs>::max(), std::numeric_limits<TimeNs>::min()})
      REQUIRE(buffer.add({impossible, {0, 0, 0}, {0, 0, 9.81}}).error() == Error::not_finite);
  }
}

TEST_CASE("imu_buffer: interpolates over a gap, and reports it") {
  const ImuBuffer<64> buffer = filled(200 * ms, 50 * ms, 150 * ms);
  const Extracted e = extract(buffer, t0 + 40 * ms, t0 + 100 * ms);
  REQUIRE(e.intervals.size() == 3);  // 40 - 45 - 50 - 100
  REQUIRE((e.intervals[2].gyro_end - linear(t0 + 100 * ms).gyro).norm() < 1e-12);
  REQUIRE((e.intervals[1].gyro_sigma == 0 && e.intervals[2].gyro_sigma == Approx(10 * 0.1 / 2 * std::sqrt(2.0))));
  REQUIRE(e.intervals[2].accel_sigma[0] == Approx(50 * 0.1 / 2 * std::sqrt(2.0)));  // half of it
  REQUIRE((e.coverage.gap_s == Approx(0.05) && e.coverage.missing() == Approx(5.0 / 6)));
  REQUIRE(extract(filled(200 * ms, 50 * ms, 70 * ms), t0, t0 + 200 * ms).coverage.gap_s == 0);  // 20 ms: no gap
}

TEST_CASE("imu_buffer: holds the nearest sample outside of its samples") {
  const ImuBuffer<64> buffer = filled(20 * ms);
  const Extracted late = extract(buffer, t0 + 15 * ms, t0 + 60 * ms);
  REQUIRE(late.intervals.size() == 2);
  REQUIRE(late.intervals[1].gyro_begin == linear(t0 + 20 * ms).gyro);
  REQUIRE(late.intervals[1].gyro_end == linear(t0 + 20 * ms).gyro);
  REQUIRE(late.intervals[1].gyro_sigma == Approx(10 * 0.04 / 2));
  REQUIRE(late.coverage.held_s == Approx(0.04));
  const Extracted early = extract(buffer, t0 - 30 * ms, t0 + 5 * ms);
  REQUIRE((early.intervals.size() == 2 && early.intervals[0].gyro_end == linear(t0).gyro));
  REQUIRE(early.intervals[0].accel_sigma[0] == Approx(50 * 0.03 / 2));
  REQUIRE(early.coverage.held_s == Approx(0.03));
  REQUIRE(extract(buffer, t0 - 30 * ms, t0 - 10 * ms).coverage.missing() == 1);
  REQUIRE(extract(buffer, t0 + 30 * ms, t0 + 40 * ms).intervals[0].gyro_sigma ==
          Approx(10 * 0.02 / 2 * std::sqrt(2.0)));
  REQUIRE(extract(buffer, t0 - 30 * ms, t0 + 40 * ms).intervals.size() == 6);
}

TEST_CASE("imu_buffer: saturated samples are clipped and their noise inflated, per sensor") {
  ImuBufferOptions options;
  options.gyro_full_scale = 4;
  options.accel_full_scale = 80;
  options.vibration = 0;
  ImuBuffer<64> buffer(options);
  for (int k = 0; k <= 8; ++k) {
    ImuSample s = linear(t0 + k * 5 * ms);
    if (k >= 2 && k <= 4) s.accel.x() = -1e9;
    if (k == 6) s.gyro.y() = 0.997 * 4;  // the largest number that a sensor gives, less its bias
    REQUIRE(buffer.add(s)->saturated == ((k >= 2 && k <= 4) || k == 6));
  }
  const Extracted e = extract(buffer, t0, t0 + 40 * ms);
  REQUIRE((e.coverage.saturated_s == Approx(0.03) && e.coverage.gyro_saturated_s == Approx(0.01)));
  REQUIRE((e.intervals[1].accel_end.x() == -80 && e.intervals[1].gyro_sigma == 0));
  for (int k = 0; k < 8; ++k) {                      // the interval from sample k to the next
    const int saturated = k >= 1 && k <= 4 ? k : 0;  // saturated intervals so far
    REQUIRE(e.intervals[k].accel_sigma[0] == Approx(80 * std::sqrt(saturated)).epsilon(1e-6));
  }
  REQUIRE((e.intervals[4].gyro_sigma == 0 && e.intervals[5].gyro_sigma == Approx(4)));
  REQUIRE((e.intervals[6].gyro_sigma == Approx(4 * std::sqrt(2.0)) && e.intervals[7].gyro_sigma == 0));
  REQUIRE(buffer.counts().saturated == 4);
}

TEST_CASE("imu_buffer: an unknown full scale is detected, and the noise inflated from then on") {
  ImuBufferOptions options;
  options.vibration = 0;
  ImuBuffer<64> buffer(options);
  TimeNs t = t0;
  for (int k = 0; k < 30; ++k, t += 5 * ms) {
    ImuSample s = linear(t);
    s.accel = {0, k % 2 == 0 ? 9.5 : 0.1 * k, 0};
    REQUIRE(buffer.add(s)->saturated == (k >= 18 && k % 2 == 0));  // it has been there ten times
  }
  REQUIRE((buffer.accel_full_scale() == 9.5 && buffer.gyro_full_scale() == buffer.options().gyro_full_scale));
  const Extracted e = extract(buffer, t0, t0 + 20 * ms);
  for (const ImuInterval<double>& i : e.intervals) REQUIRE((i.accel_sigma[0] == Approx(9.5) && i.gyro_sigma == 0));
}

TEST_CASE("imu_buffer: one error for all of a gap, wherever it is cut") {
  const ImuBuffer<64> buffer = filled(200 * ms, 50 * ms, 150 * ms);
  double variance = 0;  // of the integral
  for (TimeNs t = t0 + 50 * ms; t < t0 + 150 * ms; t += 20 * ms) {
    const ImuInterval<double> i = extract(buffer, t, t + 20 * ms).intervals.at(0);
    variance += i.gyro_sigma * i.gyro_sigma * i.dt * i.dt;
  }
  const ImuInterval<double> whole = extract(buffer, t0 + 50 * ms, t0 + 150 * ms).intervals.at(0);
  REQUIRE(whole.gyro_sigma == Approx(10 * 0.1 / 2));
  REQUIRE(std::sqrt(variance) == Approx(whole.gyro_sigma * 0.1));
}

TEST_CASE("imu_buffer: a sensor that repeats itself is frozen until it changes") {
  ImuBuffer<64> buffer;
  ImuSample s = linear(t0);
  for (int k = 0; k < 40; ++k) {
    s.t_ns = t0 + k * 5 * ms;
    REQUIRE(buffer.add(s)->frozen == (k >= 25));
  }
  const Extracted e = extract(buffer, t0, s.t_ns);
  REQUIRE(e.coverage.frozen_s == Approx(15 * 0.005));
  REQUIRE(e.intervals[38].gyro_sigma == Approx(10 * 39 * 0.005 / 2 * std::sqrt(39.0)));
  REQUIRE(!buffer.add(linear(s.t_ns + 5 * ms))->frozen);
}

TEST_CASE("imu_buffer: the noise of a vibrating accelerometer is inflated by a part of the sample differences") {
  testing::Gaussian noise(7);
  ImuBuffer<512> buffer;
  const ImuBufferOptions& options = buffer.options();
  const Vec<double, 3> sigma(0.8, 0.2, 0.4);
  const auto shaken = [&](TimeNs t) {
    ImuSample sample = linear(t0 + t);
    sample.accel += cwise_product(sigma, noise.vector<3>());
    return sample;
  };
  const auto doubt_before = [&](TimeNs t) -> Vec<double, 3> {
    return extract(buffer, t0 + t - 5 * ms, t0 + t).intervals[0].accel_sigma;
  };
  TimeNs t = 0;
  for (; t <= 1000 * ms; t += 5 * ms) REQUIRE(buffer.add(linear(t0 + t)));
  CHECK(doubt_before(1000 * ms).norm() < 1e-9);  // smooth motion is none
  for (; t <= 3000 * ms; t += 5 * ms) REQUIRE(buffer.add(shaken(t)));
  for (int k = 0; k < 3; ++k) CHECK(doubt_before(3000 * ms)[k] == Approx(options.vibration * sigma[k]).epsilon(0.25));
  const Extracted halves = extract(buffer, t0 + 2995 * ms, t0 + 2997 * ms);
  CHECK(halves.intervals[0].accel_sigma[0] * std::sqrt(2.0 / 5) == Approx(doubt_before(3000 * ms)[0]));
  for (; t <= 6000 * ms; t += 5 * ms) REQUIRE(buffer.add(linear(t0 + t)));
  CHECK(doubt_before(6000 * ms).norm() < 0.02 * sigma[0]);
  CHECK(extract(buffer, t0 + 5995 * ms, t0 + 6000 * ms).intervals[0].gyro_sigma == 0);
}

TEST_CASE("imu_buffer: drops the oldest when full") {
  const ImuBuffer<64> buffer = filled(1000 * ms);
  REQUIRE((buffer.size() == 64 && buffer[0].t_ns == t0 + (1000 - 63 * 5) * ms));
  REQUIRE(extract(buffer, t0, t0 + 1000 * ms).coverage.held_s == Approx(1 - 63 * 0.005));
}
