#pragma once
/// Successive intervals of IMU measurements, in bounded memory.                                    docs/math/imu.md
///
/// When they are full, neighboring intervals are merged in pairs (interval.hpp (2)), and later ones are merged up to
/// the same length: an integration then takes steps twice as long. 128 intervals are 0.64 s at 200 Hz, then 1.28 s in
/// steps of 10 ms, and so on.

#include <concepts>
#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/imu/interval.hpp"

namespace plumbline {

template <std::floating_point S, std::size_t Capacity = 128>
class ImuIntervals {
  static_assert(Capacity >= 2 && Capacity % 2 == 0, "plumbline: intervals are merged in pairs");

 public:
  /// Adds the next interval; false without a positive duration.
  bool add(const ImuInterval<S>& interval) {
    if (!(interval.dt > S(0))) return false;
    duration_ += interval.dt;
    if (!intervals_.empty() && intervals_.back().dt + interval.dt <= step_s_) {
      intervals_.back() = merged(intervals_.back(), interval);
      return true;
    }
    if (intervals_.full()) merge_pairs();
    return intervals_.push_back(interval);
  }
  /// Appends those that follow.
  template <std::size_t N>
  void append(const ImuIntervals<S, N>& next) {
    for (const ImuInterval<S>& interval : next) add(interval);
  }
  /// Adds white noise to the accelerometer; `sigma`: of its mean over one second [m/s^2].
  void inflate_accelerometer_noise(S sigma) {
    for (ImuInterval<S>& interval : intervals_) interval.inflate_accelerometer_noise(sigma);
  }

  S duration() const { return duration_; }  ///< [s]
  bool empty() const { return intervals_.empty(); }
  std::size_t size() const { return intervals_.size(); }
  const ImuInterval<S>& operator[](std::size_t k) const { return intervals_[k]; }
  const ImuInterval<S>& back() const { return intervals_.back(); }
  auto begin() const { return intervals_.begin(); }
  auto end() const { return intervals_.end(); }

 private:
  void merge_pairs() {
    for (std::size_t i = 0; i < Capacity / 2; ++i) intervals_[i] = merged(intervals_[2 * i], intervals_[2 * i + 1]);
    intervals_.resize(Capacity / 2);
    S duration = S(0);
    for (const ImuInterval<S>& interval : intervals_) duration += interval.dt;
    constexpr S pair = S(2.002);  // numerics: two intervals, with the rounding of time stamps
    step_s_ = pair * duration / S(Capacity);
  }

  FixedVector<ImuInterval<S>, Capacity> intervals_;
  S duration_ = S(0);
  S step_s_ = S(0);  ///< intervals up to this length are merged with the next [s]
};

}  // namespace plumbline
