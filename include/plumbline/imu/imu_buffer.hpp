#pragma once
/// Buffer of the newest IMU samples, which gives the intervals between two times for integration.   docs/math/imu.md
///
/// Treatment of a new sample:
///   not finite, or impossible time      rejected (Error::not_finite): NaN, or more than 126 years from time zero
///   older than the newest sample        inserted in order of time if no frame has used its time (`mark_used`), else
///                                       rejected (Error::late_sample)
///   repeated time stamp                 rejected (Error::late_sample)
///   time jump beyond `max_jump_s`       forward or back: the clock was set; the buffer is cleared first
///   at full scale or beyond             clipped and marked as saturated; full scale is the smaller of option and
///                                       detected value (imu/full_scale.hpp)
///   the same six numbers repeated       marked as frozen from `frozen_samples` repetitions on
///   buffer full                         the oldest sample is dropped
/// Intervals cover the requested time without gaps: linear between samples, the nearest sample held before the first
/// and after the last one. Where samples are missing, held, frozen or saturated, an interval has additional sigmas of
/// the true rates (gyro_sigma, accel_sigma), which enlarge the covariance of the increment. Let T be the whole time
/// without a live sample, dt the interval within it, and the error common to all of T:
///   sigma = s sqrt(T/dt),   s = rate of change * T/2,  or full scale when saturated                            (8)
/// Vibration of the accelerometer adds noise, since a part of it is aliased into motion. With v the variance per axis,
/// updated by the second difference of samples dt apart:
///   v += ((a_k - 2 a_k-1 + a_k-2)^2/6 - v) dt/vibration_s,   sigma = vibration sqrt(v)                         (8b)

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/ring_buffer.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/full_scale.hpp"
#include "plumbline/imu/imu_buffer_options.hpp"
#include "plumbline/imu/imu_counts.hpp"
#include "plumbline/imu/imu_coverage.hpp"
#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/sample.hpp"

namespace plumbline {

template <std::size_t Capacity = 512>
class ImuBuffer {
 public:
  /// Flags of an accepted sample.
  struct Accepted {
    bool saturated = false, frozen = false, clock_jumped = false;
  };

  explicit ImuBuffer(const ImuBufferOptions& options = {}) : options_(options) {}

  /// Adds a sample, see above.
  Result<Accepted> add(const ImuSample& sample);
  void clear() {
    items_.clear();
    used_ns_ = never_used;
  }
  /// Samples up to `t_ns` have been integrated: one that arrives later is rejected.
  void mark_used(TimeNs t_ns) { used_ns_ = t_ns; }

  bool empty() const { return items_.empty(); }
  bool full() const { return items_.full(); }
  std::size_t size() const { return items_.size(); }
  /// Sample i, 0 is the oldest.
  const ImuSample& operator[](std::size_t i) const { return items_[i].sample; }
  /// Whether the samples reach `t_ns`, so that none has to be held.
  bool reaches(TimeNs t_ns) const { return !empty() && items_.back().sample.t_ns >= t_ns; }
  const ImuCounts& counts() const { return counts_; }
  const ImuBufferOptions& options() const { return options_; }
  /// Full scale of gyroscope [rad/s] and accelerometer [m/s^2].
  double gyro_full_scale() const { return std::min(options_.gyro_full_scale, gyro_full_scale_.found()); }
  double accel_full_scale() const { return std::min(options_.accel_full_scale, accel_full_scale_.found()); }

  /// The index of the first sample after t, size() if there is none.
  std::size_t first_after(TimeNs t_ns) const {
    std::size_t low = 0, high = size();
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (items_[middle].sample.t_ns > t_ns)
        high = middle;
      else
        low = middle + 1;
    }
    return low;
  }

  /// visit(const ImuInterval<double>&) for each interval from t_begin to t_end, in order of time.
  template <class Visit>
  ImuCoverage for_each_interval(TimeNs t_begin_ns, TimeNs t_end_ns, Visit&& visit) const;

 private:
  struct Item {
    ImuSample sample;
    int repeated;                                   ///< number of earlier samples in a row with the same six numbers
    TimeNs live_ns;                                 ///< time of the first of them
    TimeNs gyro_in_range_ns, accel_in_range_ns;     ///< newest time so far without saturation
    Vec<double, 3> vibration = zeros<double, 3>();  ///< v of (8b), by axis [m^2/s^4]
  };

  /// Smallest full scale that is detected [rad/s, m/s^2]; tuned: docs/decisions/005.
  static constexpr double min_gyro_full_scale = 1, min_accel_full_scale = 5;
  static constexpr TimeNs never_used = std::numeric_limits<TimeNs>::min();
  /// Of full scale; sensor: the largest value is one unit less, and may be bias-corrected.
  static constexpr double saturation_ratio = 0.995;

  bool frozen(const Item& item) const { return item.repeated >= options_.frozen_samples; }
  bool gyro_saturated(const Item& item) const {
    return max_abs(item.sample.gyro) >= saturation_ratio * gyro_full_scale();
  }
  bool accel_saturated(const Item& item) const {
    return max_abs(item.sample.accel) >= saturation_ratio * accel_full_scale();
  }

  /// Updates repetition, saturation and vibration of item i from the items before it.
  void update_history(std::size_t i) {
    Item& item = items_[i];
    item.repeated = 0;
    item.live_ns = item.gyro_in_range_ns = item.accel_in_range_ns = item.sample.t_ns;
    if (i == 0) return;
    const Item& before = items_[i - 1];
    item.vibration = i == 1 ? before.vibration : vibration(items_[i - 2], before, item);
    if (gyro_saturated(item)) item.gyro_in_range_ns = before.gyro_in_range_ns;
    if (accel_saturated(item)) item.accel_in_range_ns = before.accel_in_range_ns;
    for (int k = 0; k < 3; ++k) {
      if (item.sample.gyro[k] != before.sample.gyro[k] || item.sample.accel[k] != before.sample.accel[k]) return;
    }
    item.repeated = std::min(before.repeated + 1, options_.frozen_samples);
    item.live_ns = before.live_ns;
  }

  /// v of (8b) after three samples in a row.
  Vec<double, 3> vibration(const Item& first, const Item& second, const Item& third) const {
    if (seconds_between(first.sample.t_ns, third.sample.t_ns) > 2 * options_.gap_s) return second.vibration;
    const Vec<double, 3> second_difference = third.sample.accel - 2 * second.sample.accel + first.sample.accel;
    const double part = seconds_between(second.sample.t_ns, third.sample.t_ns) / options_.vibration_s;
    return second.vibration +
           std::min(1.0, part) * (cwise_product(second_difference, second_difference) / 6 - second.vibration);
  }

  ImuBufferOptions options_;
  RingBuffer<Item, Capacity> items_;
  FullScaleFinder gyro_full_scale_{{.min_full_scale = min_gyro_full_scale}};
  FullScaleFinder accel_full_scale_{{.min_full_scale = min_accel_full_scale}};
  TimeNs used_ns_ = never_used;
  ImuCounts counts_;
};

template <std::size_t Capacity>
Result<typename ImuBuffer<Capacity>::Accepted> ImuBuffer<Capacity>::add(const ImuSample& sample) {
  constexpr TimeNs possible_ns = 4'000'000'000'000'000'000;  // numerics: differences fit into 64 bits
  if (!all_finite(sample.gyro) || !all_finite(sample.accel) || sample.t_ns < -possible_ns ||
      sample.t_ns > possible_ns) {
    ++counts_.not_finite;
    return Error::not_finite;
  }
  Accepted out;
  if (!empty()) {
    const double step_s = seconds_between(items_.back().sample.t_ns, sample.t_ns);
    out.clock_jumped = !(std::abs(step_s) <= options_.max_jump_s);
    if (out.clock_jumped) clear();
  }
  const std::size_t place = first_after(sample.t_ns);
  if (place > 0 && items_[place - 1].sample.t_ns == sample.t_ns) {
    ++counts_.repeated;
    return Error::late_sample;
  }
  const bool newest = place == size(), late = sample.t_ns <= used_ns_ || (place == 0 && items_.full());
  counts_.late += late;
  if (late && !newest) return Error::late_sample;
  gyro_full_scale_.add(sample.gyro);
  accel_full_scale_.add(sample.accel);
  const double w = gyro_full_scale(), a = accel_full_scale();
  Item item{};
  item.sample.t_ns = sample.t_ns;
  for (int k = 0; k < 3; ++k) {
    item.sample.gyro[k] = std::min(std::max(sample.gyro[k], -w), w);
    item.sample.accel[k] = std::min(std::max(sample.accel[k], -a), a);
  }
  const std::size_t at = items_.insert(place, item);
  for (std::size_t i = at; i < size(); ++i) update_history(i);
  out.saturated = gyro_saturated(item) || accel_saturated(item);
  out.frozen = frozen(items_[at]);
  ++counts_.accepted;
  counts_.reordered += !newest;
  counts_.clock_jumps += out.clock_jumped;
  counts_.saturated += out.saturated;
  counts_.frozen += out.frozen;
  return out;
}

template <std::size_t Capacity>
template <class Visit>
ImuCoverage ImuBuffer<Capacity>::for_each_interval(TimeNs t_begin_ns, TimeNs t_end_ns, Visit&& visit) const {
  ImuCoverage out;
  out.valid = !empty() && t_begin_ns < t_end_ns;
  if (!out.valid) return out;
  out.duration_s = seconds_between(t_begin_ns, t_end_ns);
  TimeNs t = t_begin_ns;
  for (std::size_t next = first_after(t); t < t_end_ns; ++next) {
    const bool before = next == 0, after = next >= size();
    const Item &a = items_[before ? 0 : next - 1], &b = items_[after ? size() - 1 : next];
    const TimeNs end = after ? t_end_ns : std::min(b.sample.t_ns, t_end_ns);
    const auto value_at = [&](TimeNs at, Vec<double, 3> ImuSample::*axis) -> Vec<double, 3> {
      if (before || after) return a.sample.*axis;
      const double u = seconds_between(a.sample.t_ns, at) / seconds_between(a.sample.t_ns, b.sample.t_ns);
      return (1 - u) * (a.sample.*axis) + u * (b.sample.*axis);
    };
    ImuInterval<double> interval;
    interval.dt = seconds_between(t, end);
    interval.gyro_begin = value_at(t, &ImuSample::gyro);
    interval.gyro_end = value_at(end, &ImuSample::gyro);
    interval.accel_begin = value_at(t, &ImuSample::accel);
    interval.accel_end = value_at(end, &ImuSample::accel);
    const double spacing_s = seconds_between(a.sample.t_ns, b.sample.t_ns);
    double unmeasured_s = 0;  // T of (8)
    if (before || after) {
      unmeasured_s = before ? seconds_between(t, b.sample.t_ns) : seconds_between(a.live_ns, t_end_ns);
      out.held_s += interval.dt;
    } else if (frozen(b)) {
      unmeasured_s = seconds_between(b.live_ns, b.sample.t_ns);
      out.frozen_s += interval.dt;
    } else if (spacing_s > options_.gap_s) {
      unmeasured_s = spacing_s;
      out.gap_s += interval.dt;
    }
    const TimeNs last = after ? t_end_ns : b.sample.t_ns;
    const auto sigma = [&](double rate, bool saturated, double full_scale, TimeNs in_range_ns) {  // (8)
      const double saturated_s = saturated ? std::max(interval.dt, seconds_between(in_range_ns, last)) : 0;
      return std::max(0.5 * rate * unmeasured_s * std::sqrt(unmeasured_s / interval.dt),
                      full_scale * std::sqrt(saturated_s / interval.dt));
    };
    const bool is_gyro_saturated = gyro_saturated(a) || gyro_saturated(b);
    const bool is_accel_saturated = accel_saturated(a) || accel_saturated(b);
    interval.gyro_sigma = sigma(options_.gyro_rate, is_gyro_saturated, gyro_full_scale(), a.gyro_in_range_ns);
    const double unmeasured_sigma =
        sigma(options_.accel_rate, is_accel_saturated, accel_full_scale(), a.accel_in_range_ns);
    for (int k = 0; k < 3; ++k) {
      const double vibration_sigma = options_.vibration * std::sqrt(b.vibration[k] * spacing_s / interval.dt);
      interval.accel_sigma[k] = elementary::hypot(unmeasured_sigma, vibration_sigma);
    }
    if (is_gyro_saturated) out.gyro_saturated_s += interval.dt;
    if (is_gyro_saturated || is_accel_saturated) out.saturated_s += interval.dt;
    visit(interval);
    ++out.intervals;
    t = end;
  }
  return out;
}

}  // namespace plumbline
