#pragma once
/// The newest inertial samples, and what they say about the time between two images.           docs/math/imu.md
///
/// What arrives:
///   not finite, no possible time        refused (Error::not_finite): NaN, or more than 126 years from the clock's zero
///   older than the newest sample        sorted in, as long as no frame has used its time (mark_used); else refused
///                                       (Error::late_sample)
///   repeated time stamp                 refused (Error::late_sample)
///   a jump of more than `max_jump_s`    the clock was set, forward or back: the buffer starts anew with this sample
///   at full scale or beyond             clipped to it, marked saturated; full scale is the least of what the options
///                                       say and what the readings show (imu/full_scale.hpp)
///   the same six numbers over and over  marked frozen from `frozen_samples` repetitions on
///   buffer full                         the oldest sample is forgotten
/// What is given out covers the time asked for without a hole: linear between samples, the nearest sample held before
/// the first and after the last one. Where readings are missing, held, frozen or saturated, the intervals say by how
/// much the truth may differ (gyro_sigma, accel_sigma), so that the covariance of the increment grows. With T the whole
/// time without a live reading, of which the interval dt is a part, and one error for all of it:
///   sigma = s sqrt(T/dt),   s = rate of change * T/2,  or full scale: at its rail a sensor says nothing        (8)
/// An accelerometer that shakes is doubted as well: a part of what its readings differ by from one to the next, once
/// aliased, looks like motion. With v the variance, by axis, of readings dt apart that bend by a_k - 2 a_k-1 + a_k-2,
///   v += (bend^2/6 - v) dt/vibration_s,   sigma = vibration sqrt(v)                                            (8b)

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/ring_buffer.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/full_scale.hpp"
#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/sample.hpp"

namespace plumbline {

struct ImuBufferOptions {
  double gyro_full_scale = 34.9;    ///< [rad/s], 2000 deg/s
  double accel_full_scale = 156.9;  ///< [m/s^2], 16 g
  double gap_s = 0.025;             ///< samples further apart are a gap [s]
  double gyro_rate = 10;            ///< how fast the true readings change: [rad/s^2]
  double accel_rate = 50;           ///< [m/s^3]
  double vibration = 0.3;           ///< part of how accelerations scatter that counts as noise, (8b)
  double vibration_s = 0.5;         ///< over which they scatter [s]
  double max_jump_s = 1;            ///< [s]
  int frozen_samples = 25;          ///< sensors with noise do not repeat six numbers
};

/// How the samples covered the time asked for, in seconds. Frozen and saturated time may overlap the others.
struct ImuCoverage {
  bool valid = false;  ///< there were samples at all, and the time asked for is not empty
  int intervals = 0;
  double duration_s = 0;  ///< [s]
  double gap_s = 0;       ///< interpolated over a gap
  double held_s = 0;      ///< before the first or after the last sample
  double frozen_s = 0;
  double saturated_s = 0;  ///< any of the two sensors
  double gyro_saturated_s = 0;

  /// Of both times together.
  ImuCoverage& operator+=(const ImuCoverage& next) {
    valid = valid || next.valid;
    intervals += next.intervals;
    duration_s += next.duration_s;
    gap_s += next.gap_s;
    held_s += next.held_s;
    frozen_s += next.frozen_s;
    saturated_s += next.saturated_s;
    gyro_saturated_s += next.gyro_saturated_s;
    return *this;
  }

  /// Part of the time without a live reading.
  double missing() const { return valid ? std::min(1.0, (gap_s + held_s + frozen_s) / duration_s) : 1; }
};

/// Counts since the start.
struct ImuCounts {
  std::int64_t accepted = 0, not_finite = 0, clock_jumps = 0, saturated = 0, frozen = 0;
  std::int64_t reordered = 0;  ///< sorted in
  std::int64_t repeated = 0;   ///< refused: there is a sample of that time
  std::int64_t late = 0;       ///< of a time that a frame had used: refused, but for the newest of all
};

template <std::size_t Capacity = 512>
class ImuBuffer {
 public:
  /// What was noticed about an accepted sample.
  struct Accepted {
    bool saturated = false, frozen = false, clock_jumped = false;
  };

  ImuBuffer() = default;
  explicit ImuBuffer(const ImuBufferOptions& options) : options_(options) {}

  Result<Accepted> add(const ImuSample& sample);
  void clear() {
    items_.clear();
    used_ns_ = never_used;
  }
  /// Readings up to that time have been integrated: what still comes for it is late.
  void mark_used(TimeNs t_ns) { used_ns_ = t_ns; }

  bool empty() const { return items_.empty(); }
  bool full() const { return items_.full(); }
  std::size_t size() const { return items_.size(); }
  /// Sample i, 0 is the oldest.
  const ImuSample& operator[](std::size_t i) const { return items_[i].sample; }
  /// Whether nothing needs to be held up to that time.
  bool reaches(TimeNs t_ns) const { return !empty() && items_.back().sample.t_ns >= t_ns; }
  const ImuCounts& counts() const { return counts_; }
  const ImuBufferOptions& options() const { return options_; }
  double gyro_full_scale() const { return std::min(options_.gyro_full_scale, gyro_rail_.found()); }     ///< [rad/s]
  double accel_full_scale() const { return std::min(options_.accel_full_scale, accel_rail_.found()); }  ///< [m/s^2]

  /// The index of the first sample after t, size() if there is none.
  std::size_t first_after(TimeNs t_ns) const {
    std::size_t low = 0, high = size();
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (items_[middle].sample.t_ns > t_ns) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }

  /// visit(const ImuInterval<double>&) for each interval from t_begin to t_end, in order of time.
  template <class Visit>
  ImuCoverage for_each_interval(TimeNs t_begin_ns, TimeNs t_end_ns, Visit&& visit) const;

 private:
  struct Item {
    ImuSample sample;
    int repeated;                                   ///< how often these six numbers came before
    TimeNs live_ns;                                 ///< when they came first
    TimeNs gyro_in_range_ns, accel_in_range_ns;     ///< of the newest sample so far that was not at its rail
    Vec<double, 3> vibration = zeros<double, 3>();  ///< v of (8b), by axis [m^2/s^4]
  };

  static constexpr TimeNs never_used = std::numeric_limits<TimeNs>::min();
  static constexpr double at_rail = 0.995;  ///< of full scale: the largest number is one less, and corrected for bias

  bool frozen(const Item& item) const { return item.repeated >= options_.frozen_samples; }

  bool gyro_saturated(const Item& item) const { return max_abs(item.sample.gyro) >= at_rail * gyro_full_scale(); }
  bool accel_saturated(const Item& item) const { return max_abs(item.sample.accel) >= at_rail * accel_full_scale(); }

  /// Since when item i repeats its numbers, since when its sensors are at their rails, how it shakes.
  void follow(std::size_t i) {
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

  /// (8b), of three samples in a row.
  Vec<double, 3> vibration(const Item& first, const Item& second, const Item& third) const {
    if (seconds_between(first.sample.t_ns, third.sample.t_ns) > 2 * options_.gap_s) return second.vibration;
    const Vec<double, 3> bend = third.sample.accel - 2 * second.sample.accel + first.sample.accel;
    const double part = seconds_between(second.sample.t_ns, third.sample.t_ns) / options_.vibration_s;
    return second.vibration + std::min(1.0, part) * (cwise_product(bend, bend) / 6 - second.vibration);
  }

  ImuBufferOptions options_;
  RingBuffer<Item, Capacity> items_;
  FullScaleFinder gyro_rail_{{.least = 1}}, accel_rail_{{.least = 5}};
  TimeNs used_ns_ = never_used;
  ImuCounts counts_;
};

template <std::size_t Capacity>
Result<typename ImuBuffer<Capacity>::Accepted> ImuBuffer<Capacity>::add(const ImuSample& sample) {
  constexpr TimeNs possible_ns = 4'000'000'000'000'000'000;  // differences fit into 64 bits
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
  gyro_rail_.add(sample.gyro);
  accel_rail_.add(sample.accel);
  const double w = gyro_full_scale(), a = accel_full_scale();
  Item item{};
  item.sample.t_ns = sample.t_ns;
  for (int k = 0; k < 3; ++k) {
    item.sample.gyro[k] = std::min(std::max(sample.gyro[k], -w), w);
    item.sample.accel[k] = std::min(std::max(sample.accel[k], -a), a);
  }
  const std::size_t at = items_.insert(place, item);
  for (std::size_t i = at; i < size(); ++i) follow(i);
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
    const auto reading = [&](TimeNs at, Vec<double, 3> ImuSample::*axis) -> Vec<double, 3> {
      if (before || after) return a.sample.*axis;
      const double u = seconds_between(a.sample.t_ns, at) / seconds_between(a.sample.t_ns, b.sample.t_ns);
      return (1 - u) * (a.sample.*axis) + u * (b.sample.*axis);
    };
    ImuInterval<double> interval;
    interval.dt = seconds_between(t, end);
    interval.gyro_begin = reading(t, &ImuSample::gyro);
    interval.gyro_end = reading(end, &ImuSample::gyro);
    interval.accel_begin = reading(t, &ImuSample::accel);
    interval.accel_end = reading(end, &ImuSample::accel);

    const double spacing_s = seconds_between(a.sample.t_ns, b.sample.t_ns);
    double blind_s = 0;  // time without a live reading that this interval is part of
    if (before || after) {
      blind_s = before ? seconds_between(t, b.sample.t_ns) : seconds_between(a.live_ns, t_end_ns);
      out.held_s += interval.dt;
    } else if (frozen(b)) {
      blind_s = seconds_between(b.live_ns, b.sample.t_ns);
      out.frozen_s += interval.dt;
    } else if (spacing_s > options_.gap_s) {
      blind_s = spacing_s;
      out.gap_s += interval.dt;
    }
    const TimeNs last = after ? t_end_ns : b.sample.t_ns;
    const auto doubt = [&](double rate, bool saturated, double full_scale, TimeNs in_range_ns) {  // (8)
      const double railed_s = saturated ? std::max(interval.dt, seconds_between(in_range_ns, last)) : 0;
      return std::max(0.5 * rate * blind_s * std::sqrt(blind_s / interval.dt),
                      full_scale * std::sqrt(railed_s / interval.dt));
    };
    const bool gyro_railed = gyro_saturated(a) || gyro_saturated(b);
    const bool accel_railed = accel_saturated(a) || accel_saturated(b);
    interval.gyro_sigma = doubt(options_.gyro_rate, gyro_railed, gyro_full_scale(), a.gyro_in_range_ns);
    const double unread = doubt(options_.accel_rate, accel_railed, accel_full_scale(), a.accel_in_range_ns);
    for (int k = 0; k < 3; ++k) {
      const double shaken = options_.vibration * std::sqrt(b.vibration[k] * spacing_s / interval.dt);
      interval.accel_sigma[k] = std::hypot(unread, shaken);
    }
    if (gyro_railed) out.gyro_saturated_s += interval.dt;
    if (gyro_railed || accel_railed) out.saturated_s += interval.dt;
    visit(interval);
    ++out.intervals;
    t = end;
  }
  return out;
}

}  // namespace plumbline
