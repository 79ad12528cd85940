#pragma once
/// Dead reckoning: the state of a body propagated by the IMU alone, with the covariance of its pose.
///                                                                              docs/math/initialization.md (9)
/// After max_s, and from the first unusable sample of the accelerometer on, velocity and position are unknown: the
/// position is held and its sigma grows with lost_speed.

#include <cmath>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/propagation/covariance_growth.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

struct DeadReckoningOptions {
  double max_s = 3;  ///< longest propagation of the position [s]; tuned: docs/decisions/016
  /// Random walk of the position by bias and tilt errors [m/sqrt(s)]; tuned: docs/decisions/130 (chosen).
  double velocity_walk = 0.1;
  double rate_error = 5e-3;  ///< sigma of the gyroscope bias [rad/s]; tuned: docs/decisions/021
  /// Sigma of the speed of a body that is not observed [m/s]; tuned: docs/decisions/131 (chosen).
  double lost_speed = 1;
  /// Sigma of its angular rate without gyroscope [rad/s]; tuned: docs/decisions/131 (chosen).
  double lost_rate = 1;
};

template <class S>
class DeadReckoning {
 public:
  using Covariance = Mat<S, 6, 6>;

  explicit DeadReckoning(const DeadReckoningOptions& options = {}) : options_(options) {}

  /// Starts at the state x with the covariance P of its pose [rad, m] and the sigma of its velocity [m/s].
  void begin(const NavState<S>& x, const Covariance& P, S velocity_sigma) {
    x_ = x;
    P_ = P;
    velocity_sigma_ = velocity_sigma;
    since_s_ = S(0);
    begun_ = true;
    lost_ = counted_ = false;
  }
  /// The velocity is unknown from now on. The caller counts this loss.
  void mark_lost() { lost_ = counted_ = true; }

  /// Propagates over the time dt [s] since the last frame. `unusable`: the accelerometer does not determine the motion;
  /// `missing`: neither does the gyroscope.
  void advance(const ImuIncrement<S>& increment, const Vec<S, 3>& gravity, S dt, bool unusable, bool missing) {
    if (!begun_) return;
    since_s_ += dt;
    lost_ = lost_ || unusable || missing || !(since_s_ < S(options_.max_s));
    NavState<S> x = increment.predict(x_, gravity);
    if (lost_) {
      const SO3<S> R = missing ? x_.T_world_body.rotation() : x.T_world_body.rotation();
      x = x_;
      x.T_world_body = SE3<S>(R, x_.T_world_body.p());
    }
    P_ = transported(P_, x_.T_world_body, x.T_world_body);
    x_ = x;
    const CovarianceGrowth<S> growth{.rate_sigma = S(missing ? options_.lost_rate : options_.rate_error),
                                     .speed_sigma = lost_ ? S(options_.lost_speed) : velocity_sigma_,
                                     .position_walk = S(options_.velocity_walk)};
    growth.add_to(P_, since_s_, dt);
  }

  /// True once after each loss.
  bool count_loss() {
    const bool counts = lost_ && !counted_;
    counted_ = counted_ || lost_;
    return counts;
  }

  /// Whether this position is preferred to another estimate p with its sigma [m]: p is beyond three sigmas of both, or
  /// its sigma is more than twice the one here.
  bool is_preferred_to(const Vec<S, 3>& p, S sigma) const {
    const S position_sigma = std::sqrt(P_(3, 3)), gate = gate_sigmas * elementary::hypot(sigma, position_sigma);
    const bool excludes = !lost_ && !(norm(Vec<S, 3>(p - x_.T_world_body.p())) <= gate);
    return begun_ && (excludes || !(sigma <= max_sigma_ratio * position_sigma));
  }

  bool has_begun() const { return begun_; }
  bool is_lost() const { return lost_; }
  const NavState<S>& state() const { return x_; }
  const Covariance& covariance() const { return P_; }

 private:
  static constexpr S gate_sigmas = S(3), max_sigma_ratio = S(2);  ///< tuned: docs/decisions/026

  DeadReckoningOptions options_;
  NavState<S> x_;
  Covariance P_ = zeros<Covariance>();
  S velocity_sigma_ = S(0), since_s_ = S(0);
  bool begun_ = false, lost_ = false, counted_ = false;
};

}  // namespace plumbline
