#pragma once
/// Samples of an IMU from one file, or from one of the gyroscope and one of the accelerometer.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/error.hpp"
#include "plumbline/io/held_samples.hpp"
#include "plumbline/io/index_rows.hpp"

namespace plumbline::io::detail {

/// Values held between the true samples of a slower sensor become linear; says so. Of the accelerometer.
inline HeldSensor note_held(const Path& file, std::vector<ImuSample>& samples, std::vector<std::string>& notes) {
  if (samples.size() < 2) return {};
  const double rows_hz =
      static_cast<double>(samples.size() - 1) / seconds_between(samples.front().t_ns, samples.back().t_ns);
  const auto interpolate = [&](ImuMember sensor, const std::string& name) {
    const HeldSensor held = interpolate_held(samples, sensor);
    if (held.rate_hz > 0)
      notes.push_back(file.string() + ": the " + name + " has new values at " +
                      std::to_string(std::llround(held.rate_hz)) + " Hz, repeated in rows of " +
                      std::to_string(std::llround(rows_hz)) + " Hz: interpolated between its true samples");
    return held;
  };
  interpolate(&ImuSample::gyro, "gyroscope");
  return interpolate(&ImuSample::accel, "accelerometer");
}

/// Rows "time, gyroscope x y z [rad/s], accelerometer x y z [m/s^2]". Rows with a NaN are skipped.
inline std::vector<ImuSample> read_imu_samples(const Path& file, TimeUnit expected, std::vector<std::string>& notes) {
  std::vector<ImuSample> samples;
  SkippedRows skipped;
  const TimeUnit unit = unit_of(file, expected, notes);
  std::size_t rows = 0;
  bool is_said = false;
  for (RowReader row(file); row.next();) {
    ++rows;
    if (!has_columns(row, 7, file, skipped, notes, is_said)) continue;
    const TimeNs t = row.time_in(unit);
    if (!is_after(row, samples, t, skipped)) continue;
    std::size_t bad = 1;
    while (bad < 7 && !row.is_not_finite(bad)) ++bad;
    if (bad < 7) {
      skipped.add(row, "a value is not finite", ": column " + std::to_string(bad + 1));
      continue;
    }
    samples.push_back(
        {t, {row.number(1), row.number(2), row.number(3)}, {row.number(4), row.number(5), row.number(6)}});
  }
  skipped.report(file, rows, notes);
  if (samples.empty()) throw ReadError(file, 0, "has no IMU samples");
  return samples;
}

/// A sample of one sensor.
struct SensorSample {
  TimeNs t_ns;
  Vec<double, 3> value;
};

/// Rows "time, x y z". Rows with a NaN are skipped.
inline std::vector<SensorSample> read_sensor(const Path& file, TimeUnit expected, std::vector<std::string>& notes) {
  std::vector<SensorSample> samples;
  SkippedRows skipped;
  const TimeUnit unit = unit_of(file, expected, notes);
  std::size_t rows = 0;
  bool is_said = false;
  for (RowReader row(file); row.next();) {
    ++rows;
    if (!has_columns(row, 4, file, skipped, notes, is_said)) continue;
    const TimeNs t = row.time_in(unit);
    if (!is_after(row, samples, t, skipped)) continue;
    if (row.is_not_finite(1) || row.is_not_finite(2) || row.is_not_finite(3)) {
      skipped.add(row, "a value is not finite");
      continue;
    }
    samples.push_back({t, {row.number(1), row.number(2), row.number(3)}});
  }
  skipped.report(file, rows, notes);
  if (samples.empty()) throw ReadError(file, 0, "has no samples");
  return samples;
}

/// The samples of the gyroscope, each with the accelerometer linear between its two samples around it. Those without
/// are left
/// out: before the first, after the last, or in a gap of more than 0.1 s.
inline std::vector<ImuSample> read_separate_sensors(const Path& gyro_file, const Path& accel_file, TimeUnit expected,
                                                    std::vector<std::string>& notes, HeldSensor& held_accel) {
  constexpr double longest_gap_s = 0.1;
  const std::vector<SensorSample> gyro = read_sensor(gyro_file, expected, notes);
  const std::vector<SensorSample> accel = read_sensor(accel_file, expected, notes);
  std::vector<ImuSample> out;
  auto after = accel.begin();
  for (const SensorSample& sample : gyro) {
    while (after != accel.end() && after->t_ns < sample.t_ns) ++after;
    if (after == accel.end()) break;
    if (after->t_ns == sample.t_ns) {
      out.push_back({sample.t_ns, sample.value, after->value});
      continue;
    }
    if (after == accel.begin()) continue;
    const SensorSample& before = *std::prev(after);
    const double gap_s = seconds_between(before.t_ns, after->t_ns);
    if (gap_s > longest_gap_s) continue;
    const double part = seconds_between(before.t_ns, sample.t_ns) / gap_s;
    out.push_back({sample.t_ns, sample.value, (1 - part) * before.value + part * after->value});
  }
  if (out.empty())
    throw ReadError(accel_file, 0,
                    "no sample is within 0.1 s of one of " + gyro_file.filename().string() +
                        ": do both have the same clock and unit of time?");
  const auto rate_of = [](const std::vector<SensorSample>& samples) {
    const double duration_s = seconds_between(samples.front().t_ns, samples.back().t_ns);
    return samples.size() < 2 ? 0 : static_cast<double>(samples.size() - 1) / duration_s;
  };
  const auto text = [](double rate) { return std::to_string(std::llround(rate)) + " Hz"; };
  std::string note = accel_file.string() + ": the accelerometer has " + text(rate_of(accel)) +
                     ", interpolated to the times of the gyroscope (" + text(rate_of(gyro)) + ")";
  if (out.size() < gyro.size())
    note += "; " + std::to_string(gyro.size() - out.size()) + " of " + std::to_string(gyro.size()) +
            " of its samples are left out: the accelerometer has none around them";
  notes.push_back(note);
  if (rate_of(accel) < 0.9 * rate_of(gyro)) {
    std::vector<Vec<double, 3>> values;
    values.reserve(accel.size());
    for (const SensorSample& sample : accel) values.push_back(sample.value);
    held_accel = {rate_of(accel), scatter_density(values, rate_of(accel))};
  }
  return out;
}

}  // namespace plumbline::io::detail
