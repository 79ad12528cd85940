#pragma once
/// The IMU factors between the frames of a window.                                     docs/math/inertial_window.md
///
/// The factor of a frame is the preintegrated increment from the previous frame to it, whitened by the square root of
/// its information, and at rest the zero-velocity rows (1). The factors of a marginalized frame go into the prior; no
/// factor then connects the frames before and after it.

#include <array>

#include "plumbline/core/matrix.hpp"
#include "plumbline/factor/zero_velocity.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/propagation/camera_time_offset.hpp"
#include "plumbline/propagation/imu_factor.hpp"
#include "plumbline/residual/inertial.hpp"
#include "plumbline/residual/time_offset_shift.hpp"
#include "plumbline/state/estimated.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class S, int Slots>
class ImuFactors {
 public:
  using Layout = InertialLayout;
  using Factor = ImuFactor<S>;

  explicit ImuFactors(const ImuFactorOptions& options)
      : options_(options), gravity_(gravity_in_world<S>(S(options.gravity))) {}

  const Vec<S, 3>& gravity() const { return gravity_; }

  /// Factors contribute to the cost from `activate` on. Before, velocities and biases are constant.
  bool active() const { return active_; }
  void activate() { active_ = true; }
  void deactivate() { active_ = false; }

  /// Sets the factor of a frame in state x. When its accelerometer is suspect and that of the previous one was not, the
  /// accelerometer noise of all earlier factors is inflated as well: the error began before it was detected.
  void insert(int slot, const NavState<S>& x, const Factor& factor) {
    if (factor.is_accel_suspect && !is_accel_suspect_) inflate_accelerometer_noise();
    is_accel_suspect_ = factor.is_accel_suspect;
    factors_[slot].factor = factor;
    factors_[slot].is_checked = true;
    integrate(factors_[slot], x.bias_gyro, x.bias_accel);
  }
  /// Removes the factors of a frame. What they determined is in the prior if the frame was marginalized.
  void remove(int slot) {
    factors_[slot].factor.previous = -1;
    for (Weighted& weighted : factors_) {
      if (weighted.factor.previous == slot) weighted.factor.previous = -1;
    }
  }

  int previous(int slot) const { return factors_[slot].factor.previous; }
  const ImuIncrement<S>& increment(int slot) const { return factors_[slot].increment; }

  /// Initial velocities v_i = (p_j - p_free)/Dt, from given poses and biases.    docs/math/inertial_window.md (1j)
  template <class Window>
  void initialize_velocities(Window& window) const {
    using Velocity = Estimated<state::Velocity, S>;
    const auto set = [&](int slot, const Vec<S, 3>& v) {
      window.state(slot).template get<state::Velocity>() = Velocity(v);
    };
    for (int j = 0; j < Slots; ++j) {
      if (!has_factor(window, j)) continue;
      const ImuIncrement<S>& increment = factors_[j].increment;
      const int i = previous(j);
      NavState<S> x_i = window[i].state.value();
      set_zero(x_i.v_world_body);
      const NavState<S> x_free = increment.predict(x_i, gravity_);
      x_i.v_world_body = (window.T_world_body(j).p() - x_free.T_world_body.p()) / increment.duration;
      set(i, x_i.v_world_body);
      set(j, increment.predict(x_i, gravity_).v_world_body);
    }
  }

  /// Integrates the increments again whose bias has moved too far for the first-order correction. Call it between
  /// optimizations.
  void reintegrate(const auto& window) {
    for (int slot = 0; slot < Slots; ++slot) {
      if (!has_factor(window, slot)) continue;
      const NavState<S> x = window[previous(slot)].state.value();
      if (factors_[slot].increment.is_far(x.bias_gyro)) integrate(factors_[slot], x.bias_gyro, x.bias_accel);
    }
  }

  /// Linearizes all factors of `slot`, or every factor for -1, and calls take(i, J_i, j, J_j, J_offset, r) with their
  /// whitened rows; J_offset is the column of the time offset.                    docs/math/camera_imu.md (6)
  void for_each_row(const auto& window, int slot, auto&& take) const {
    for (int j = 0; active_ && j < Slots; ++j) {
      if (!has_factor(window, j)) continue;
      const Weighted& weighted = factors_[j];
      const int i = weighted.factor.previous;
      if (slot >= 0 && i != slot && j != slot) continue;
      const NavState<S> x_i = window[i].state.value(), x_j = window[j].state.value();
      const NavState<S> x_i0 = window[i].state.first_estimate(), x_j0 = window[j].state.first_estimate();
      if (weighted.valid) {
        const Ends at = ends(window, weighted.factor);
        auto inertial = InertialResidual<S>{weighted.increment, gravity_}.linearize(at.begin(x_i), at.end(x_j),
                                                                                    at.begin(x_i0), at.end(x_j0));
        if (inertial.valid) {
          inertial.whiten(weighted.L);
          const Vec<S, 15> by_begin = at.begin.pull_back(x_i0, inertial.J_r_i);
          const Vec<S, 15> J_offset = by_begin + at.end.pull_back(x_j0, inertial.J_r_j);
          take(i, inertial.J_r_i, j, inertial.J_r_j, J_offset, inertial.r);
        }
      }
      if (!weighted.factor.is_stationary) continue;
      const auto at_rest = zero_velocity().linearize(x_i, x_i0, x_j, x_j0);
      take(i, at_rest.J_i, j, at_rest.J_j, zeros<S, ZeroVelocityFactor<S>::rows>(), at_rest.r);
    }
  }

  double cost(const auto& window) const {
    double sum = 0;
    for (int j = 0; active_ && j < Slots; ++j) {
      if (!has_factor(window, j)) continue;
      const Weighted& weighted = factors_[j];
      const NavState<S> x_i = window[weighted.factor.previous].state.value(), x_j = window[j].state.value();
      if (weighted.valid) {
        const Ends at = ends(window, weighted.factor);
        const Vec<S, 15> r = InertialResidual<S>{weighted.increment, gravity_}.residual(at.begin(x_i), at.end(x_j));
        sum += squared_norm(times(weighted.L, r)) / 2;
      }
      if (weighted.factor.is_stationary) zero_velocity().add_cost(x_i, x_j, sum);
    }
    return sum;
  }

  /// Excludes the factor from `disagreement`, or includes it. One whose frames were not optimized together is excluded.
  void set_checked(int slot, bool checked) { factors_[slot].is_checked = checked; }
  /// Mean squared whitened residual of rotation, position and velocity over all factors (1a): about 1 where IMU and
  /// states agree within the noise, 0 without factors.
  double disagreement(const auto& window) const {
    constexpr int compared =
        Layout::dim - state::GyroBias::dim - state::AccelBias::dim;  // the rows of the biases are near 0
    double sum = 0;
    int factors = 0;
    for (int j = 0; j < Slots; ++j) {
      if (!has_factor(window, j) || !factors_[j].valid || !factors_[j].is_checked) continue;
      const InertialResidual<S> inertial{factors_[j].increment, gravity_};
      const Ends at = ends(window, factors_[j].factor);
      const Vec<S, 15> r =
          inertial.residual(at.begin(window[previous(j)].state.value()), at.end(window[j].state.value()));
      sum += squared_norm(times(factors_[j].L, r));
      ++factors;
    }
    return factors > 0 ? sum / (compared * factors) : 0;
  }

 private:
  struct Weighted {
    Factor factor;
    ImuIncrement<S> increment;  ///< of the factor's samples
    bool valid = false;         ///< the increment has samples and an information matrix
    bool is_checked = true;     ///< included in `disagreement`
    Mat<S, 15, 15> L;           ///< square root information of the increment
  };

  /// Shifts from the frames' image times to the boundaries of the samples, by the present time offset.
  struct Ends {
    TimeOffsetShift<S> begin, end;
  };
  Ends ends(const auto& window, const Factor& factor) const {
    const auto shift = [&](const SampleBoundary<S>& boundary) {
      return boundary.shift(window.time_offset_s(boundary.offset_s));
    };
    return {shift(factor.begin), shift(factor.end)};
  }

  bool has_factor(const auto& window, int slot) const { return window[slot].used && previous(slot) >= 0; }

  void inflate_accelerometer_noise() {
    for (Weighted& weighted : factors_) {
      if (weighted.factor.previous < 0) continue;
      weighted.factor.samples.inflate_accelerometer_noise(S(options_.suspect_accel_sigma));
      integrate(weighted, weighted.increment.bias_gyro, weighted.increment.bias_accel);
    }
  }
  void integrate(Weighted& weighted, const Vec<S, 3>& bias_gyro, const Vec<S, 3>& bias_accel) const {
    const Factor& factor = weighted.factor;
    weighted.increment = integrated(factor.samples, factor.noise, bias_gyro, bias_accel);
    const auto L = factor.jumped ? square_root_information(inflated_by_jump(weighted.increment))
                                 : weighted.increment.square_root_information();
    weighted.valid = bool(L) && !factor.samples.empty();
    if (weighted.valid) weighted.L = *L;
  }

  /// Covariance of an increment in which the gyroscope bias jumped, inflated by     docs/math/inertial_window.md (1h)
  ///   rotation b Dt,   velocity G b Dt^2/2,   position G b Dt^3/6,   bias b,        b = jump_gyro_bias (sigmas)
  Mat<S, 15, 15> inflated_by_jump(const ImuIncrement<S>& increment) const {
    Mat<S, 15, 15> P = increment.covariance;
    const S jump = S(options_.jump_gyro_bias), t = increment.duration, rotation = jump * t;
    const S velocity = S(options_.gravity) * rotation * t / 2, position = velocity * t / 3;
    for (int k = 0; k < 3; ++k) {
      P(k, k) += rotation * rotation;
      P(3 + k, 3 + k) += position * position;
      P(6 + k, 6 + k) += velocity * velocity;
      P(Layout::offset<state::GyroBias> + k, Layout::offset<state::GyroBias> + k) += jump * jump;
    }
    return P;
  }

  ZeroVelocityFactor<S> zero_velocity() const {
    return {options_.zero_velocity_sigma, options_.stationary_rotation_sigma, options_.stationary_position_sigma};
  }

  ImuFactorOptions options_;
  Vec<S, 3> gravity_;
  bool active_ = false, is_accel_suspect_ = false;
  std::array<Weighted, Slots> factors_;
};

}  // namespace plumbline
