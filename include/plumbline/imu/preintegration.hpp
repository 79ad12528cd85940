#pragma once
/// Preintegrated increment that keeps its intervals (imu_intervals.hpp), so that it can be re-integrated about other
/// biases. Intervals that are merged do not change the increment.                                  docs/math/imu.md

#include <concepts>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/imu_intervals.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/noise.hpp"

namespace plumbline {

/// The increment over some intervals, linearized about the biases.
template <std::floating_point S, std::size_t N>
ImuIncrement<S> integrated(const ImuIntervals<S, N>& intervals, const ImuNoise& noise, const Vec<S, 3>& bias_gyro,
                           const Vec<S, 3>& bias_accel) {
  ImuIncrement<S> out(bias_gyro, bias_accel);
  for (const ImuInterval<S>& interval : intervals) out.integrate(interval, noise);
  return out;
}

template <std::floating_point S, std::size_t Capacity = 128>
class Preintegration {
 public:
  using Scalar = S;
  using Intervals = ImuIntervals<S, Capacity>;

  Preintegration() = default;
  explicit Preintegration(const ImuNoise& noise, const Vec<S, 3>& bias_gyro = zeros<S, 3>(),
                          const Vec<S, 3>& bias_accel = zeros<S, 3>())
      : noise_(noise), increment_(bias_gyro, bias_accel) {}
  /// Integrates intervals about zero biases.
  Preintegration(const ImuNoise& noise, const Intervals& intervals) : Preintegration(noise) {
    for (const ImuInterval<S>& interval : intervals) add(interval);
  }

  /// Adds the next interval; false without a positive duration.
  bool add(const ImuInterval<S>& interval) {
    if (!intervals_.add(interval)) return false;
    increment_.integrate(interval, noise_);
    return true;
  }

  /// Appends the preintegration that follows, as when the state between the two is removed.
  void append(const Preintegration& next) {
    for (const ImuInterval<S>& interval : next.intervals_) add(interval);
  }

  /// Integrates all intervals again about other biases.
  void reintegrate(const Vec<S, 3>& bias_gyro, const Vec<S, 3>& bias_accel) {
    increment_ = integrated(intervals_, noise_, bias_gyro, bias_accel);
  }

  const ImuIncrement<S>& increment() const { return increment_; }
  const Intervals& intervals() const { return intervals_; }
  const ImuNoise& noise() const { return noise_; }
  bool empty() const { return intervals_.empty(); }

 private:
  ImuNoise noise_;
  ImuIncrement<S> increment_;
  Intervals intervals_;
};

}  // namespace plumbline
