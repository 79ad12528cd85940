#pragma once
/// Preintegrated increment that keeps its intervals, so that it can be re-integrated about other biases.
/// docs/math/imu.md
///
/// The number of intervals is bounded. When it is reached, neighboring intervals are merged in pairs (interval.hpp
/// (2)), and later ones are merged up to the same length. The increment itself does not change; a later re-integration
/// takes steps twice as long. 128 intervals are 0.64 s at 200 Hz, then 1.28 s in steps of 10 ms, and so on.

#include <concepts>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/interval.hpp"
#include "plumbline/imu/noise.hpp"

namespace plumbline {

template <std::floating_point S, std::size_t Capacity = 128>
class Preintegration {
  static_assert(Capacity >= 2 && Capacity % 2 == 0, "plumbline: intervals are merged in pairs");

 public:
  using Scalar = S;
  using Intervals = FixedVector<ImuInterval<S>, Capacity>;

  Preintegration() = default;
  explicit Preintegration(const ImuNoise& noise, const Vec<S, 3>& bias_gyro = zeros<S, 3>(),
                          const Vec<S, 3>& bias_accel = zeros<S, 3>())
      : noise_(noise), increment_(bias_gyro, bias_accel) {}

  /// Adds the next interval; false without a positive duration.
  bool add(const ImuInterval<S>& interval) {
    if (!(interval.dt > S(0))) return false;
    increment_.integrate(interval, noise_);
    if (!intervals_.empty() && intervals_.back().dt + interval.dt <= step_s_) {
      intervals_.back() = merged(intervals_.back(), interval);
      return true;
    }
    if (intervals_.full()) merge_pairs();
    return intervals_.push_back(interval);
  }

  /// Appends the preintegration that follows, as when the state between the two is removed.
  void append(const Preintegration& next) {
    for (const ImuInterval<S>& interval : next.intervals_) add(interval);
  }

  /// Integrates all intervals again about other biases.
  void reintegrate(const Vec<S, 3>& bias_gyro, const Vec<S, 3>& bias_accel) {
    increment_ = ImuIncrement<S>(bias_gyro, bias_accel);
    for (const ImuInterval<S>& interval : intervals_) increment_.integrate(interval, noise_);
  }

  /// Adds white noise to the accelerometer; `sigma`: of its mean over one second [m/s^2].
  void inflate_accelerometer_noise(S sigma) {
    for (ImuInterval<S>& interval : intervals_) interval.inflate_accelerometer_noise(sigma);
    reintegrate(increment_.bias_gyro, increment_.bias_accel);
  }

  /// Whether the first-order correction (7) to this gyroscope bias is inaccurate: a rotation of more than 0.01 rad, or
  /// a second-order error of the velocity above a tenth of its sigma. The accelerometer bias is corrected exactly.
  bool is_far(const Vec<S, 3>& bias_gyro) const {
    const Vec<S, 3> d = bias_gyro - increment_.bias_gyro;
    const S angle = norm(d) * increment_.duration, variance = increment_.covariance(6, 6);
    const S velocity = norm(increment_.J_v_g() * d) * angle;
    constexpr S max_angle = S(0.01), max_error2 = S(0.01);  // numerics: error of (7) below a tenth of its sigma
    return !(angle <= max_angle) || velocity * velocity > max_error2 * variance;
  }

  const ImuIncrement<S>& increment() const { return increment_; }
  const Intervals& intervals() const { return intervals_; }
  const ImuNoise& noise() const { return noise_; }
  bool empty() const { return intervals_.empty(); }

 private:
  void merge_pairs() {
    for (std::size_t i = 0; i < Capacity / 2; ++i) intervals_[i] = merged(intervals_[2 * i], intervals_[2 * i + 1]);
    intervals_.resize(Capacity / 2);
    S duration = S(0);
    for (const ImuInterval<S>& interval : intervals_) duration += interval.dt;
    constexpr S pair = S(2.002);  // numerics: two intervals, with the rounding of time stamps
    step_s_ = pair * duration / S(Capacity);
  }

  ImuNoise noise_;
  ImuIncrement<S> increment_;
  Intervals intervals_;
  S step_s_ = S(0);  ///< intervals up to this length are merged with the next [s]
};

}  // namespace plumbline
