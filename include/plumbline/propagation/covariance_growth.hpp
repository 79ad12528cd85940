#pragma once
/// Growth of the covariance of a pose that no image observes: constant unknown errors of rate and velocity, and a
/// random walk of the position. With an IMU the noise of its increment is added by the caller.
///                                                                              docs/math/inertial_window.md (1f)
///   P(T) = P(T - t) + diag(w^2 (T^2 - (T - t)^2) I, (q^2 t + v^2 (T^2 - (T - t)^2)) I)
/// T: time since the last observation, t: the part of it that is added. The parts of any division of T add up to the
/// same covariance.

#include <concepts>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S>
struct CovarianceGrowth {
  S rate_sigma = S(0);     ///< w, of the angular rate [rad/s]
  S speed_sigma = S(0);    ///< v, of the velocity [m/s]
  S position_walk = S(0);  ///< q [m/sqrt(s)]

  /// Variance of the rotation on each axis by the last dt of outage_s seconds without images [rad^2].
  S rotation_variance(S outage_s, S dt) const { return rate_sigma * rate_sigma * squares(outage_s, dt); }
  /// The same of the position [m^2].
  S position_variance(S outage_s, S dt) const {
    return position_walk * position_walk * dt + speed_sigma * speed_sigma * squares(outage_s, dt);
  }
  /// Adds both to P, of right increments [dphi, dp].
  void add_to(Mat<S, 6, 6>& P, S outage_s, S dt) const {
    const S rotation = rotation_variance(outage_s, dt), position = position_variance(outage_s, dt);
    for (int k = 0; k < 3; ++k) {
      P(k, k) += rotation;
      P(3 + k, 3 + k) += position;
    }
  }

 private:
  /// T^2 - (T - t)^2
  static S squares(S T, S t) { return (2 * T - t) * t; }
};

}  // namespace plumbline
