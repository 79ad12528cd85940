#pragma once
/// A sensor of the IMU that is sampled more slowly than its rows: its value is repeated until the next one comes, as
/// drivers do that write gyroscope and accelerometer into common rows. A repeated value taken for a sample is late by
/// half its period on average. Here the values between two true samples become linear in time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"

namespace plumbline::io {

using ImuMember = decltype(&ImuSample::accel);

/// Indices of the rows with a new value of one sensor; empty unless the others repeat the value above in a regular way:
/// at most 6 of 10 rows are new, 9 of 10 values last as long as the median one or a row more or less, and at most 50
/// ms.
inline std::vector<std::size_t> true_samples(const std::vector<ImuSample>& samples, ImuMember sensor) {
  constexpr std::size_t least = 20;
  std::vector<std::size_t> changes, lengths;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (i == 0 || samples[i].*sensor != samples[i - 1].*sensor) changes.push_back(i);
  if (changes.size() < least || 10 * changes.size() > 6 * samples.size()) return {};
  for (std::size_t k = 1; k < changes.size(); ++k) lengths.push_back(changes[k] - changes[k - 1]);
  std::vector<std::size_t> sorted = lengths;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t usual = sorted[sorted.size() / 2];
  const auto regular =
      std::count_if(lengths.begin(), lengths.end(), [&](std::size_t n) { return n + 1 >= usual && n <= usual + 1; });
  const double period_s = seconds_between(samples[changes.front()].t_ns, samples[changes.back()].t_ns) /
                          static_cast<double>(changes.size() - 1);
  if (10 * static_cast<std::size_t>(regular) < 9 * lengths.size() || period_s > 0.05) return {};
  return changes;
}

struct HeldSensor {
  double rate_hz = 0;  ///< of the true samples; 0: nothing is held
  /// sqrt(v T) of the true samples, T apart: their scatter v as a white noise density [unit/sqrt(Hz)]. The estimator
  /// finds
  /// vibration from second differences, which vanish where values are interpolated.       docs/math/imu.md (8b)
  double scatter_density = 0;
};

/// sqrt(v T) of samples with the period T.
inline double scatter_density(const std::vector<Vec<double, 3>>& values, double rate_hz) {
  if (values.size() < 3) return 0;
  double squares = 0;
  for (std::size_t k = 2; k < values.size(); ++k)
    squares += (values[k] - 2 * values[k - 1] + values[k - 2]).squaredNorm();
  return std::sqrt(squares / (6 * 3 * static_cast<double>(values.size() - 2)) / rate_hz);  // v is of one axis
}

/// Makes the values of one sensor linear between its true samples.
inline HeldSensor interpolate_held(std::vector<ImuSample>& samples, ImuMember sensor) {
  const std::vector<std::size_t> changes = true_samples(samples, sensor);
  if (changes.empty()) return {};
  std::vector<Vec<double, 3>> values;
  values.reserve(changes.size());
  for (const std::size_t i : changes) values.push_back(samples[i].*sensor);
  for (std::size_t k = 1; k < changes.size(); ++k) {
    const ImuSample &a = samples[changes[k - 1]], &b = samples[changes[k]];
    const double duration_s = seconds_between(a.t_ns, b.t_ns);
    for (std::size_t i = changes[k - 1] + 1; i < changes[k]; ++i) {
      const double part = seconds_between(a.t_ns, samples[i].t_ns) / duration_s;
      samples[i].*sensor = (1 - part) * (a.*sensor) + part * (b.*sensor);
    }
  }
  const double rate_hz = static_cast<double>(changes.size() - 1) /
                         seconds_between(samples[changes.front()].t_ns, samples[changes.back()].t_ns);
  return {rate_hz, scatter_density(values, rate_hz)};
}

}  // namespace plumbline::io
