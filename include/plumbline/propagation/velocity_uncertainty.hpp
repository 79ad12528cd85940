#pragma once
/// What the window knows of the velocity of a body, and how an outage enlarges the covariance of its pose.
///                                                                             docs/math/inertial_window.md (1f)

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/propagation/covariance_growth.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class S>
class VelocityUncertainty {
 public:
  /// Covariance of pose and velocity.
  using Covariance = Mat<S, MovingLayout::dim, MovingLayout::dim>;

  /// `unknown_sigma`: sigma of a predicted velocity that the window does not determine [m/s].
  explicit VelocityUncertainty(double unknown_sigma) : unknown_sigma_(unknown_sigma), sigma_(unknown_sigma) {}

  /// Sets the sigma of the latest state: that of the window times `inflation`.
  void set_latest(const Covariance& P, double inflation) {
    sigma_ = std::min(unknown_sigma_, inflation * largest_sigma(P));
  }
  /// The window does not determine the velocity of the latest state.
  void set_unknown() { sigma_ = unknown_sigma_; }
  bool is_known() const { return sigma_ < unknown_sigma_; }
  double sigma() const { return sigma_; }

  /// Sets speed and sigma of the last state solved with the window: covariance P, velocity v [m/s].
  void set_solved(const Covariance& P, const Vec<S, 3>& v) {
    solved_sigma_ = largest_sigma(P);
    speed_ = std::sqrt(double(squared_norm(v)));
    speed_sigma_ = std::sqrt(double(dot(v, block<3, 3>(P, at_velocity, at_velocity) * v))) / speed_;
  }
  void reset_speed() { speed_ = 0; }
  /// Speed of that state and its sigma [m/s]. Without depth its relative sigma bounds that of the scale.
  double speed() const { return speed_; }
  double speed_sigma() const { return speed_sigma_; }

  /// Covariance of a pose after one more frame of IMU-only propagation, outage_s after the last usable frame.     (1f)
  Mat<S, 6, 6> grown(const Mat<S, 6, 6>& before, const ImuIncrement<S>& increment, S outage_s) const {
    Mat<S, 6, 6> out = before + block<6, 6>(increment.covariance, 0, 0);
    const CovarianceGrowth<S> growth{.speed_sigma = S(solved_sigma_), .position_walk = S(unknown_sigma_)};
    growth.add_to(out, outage_s, increment.duration);
    return out;
  }

 private:
  static constexpr int at_velocity = MovingLayout::offset<state::Velocity>;
  static double largest_sigma(const Covariance& P) {
    constexpr int v = at_velocity;
    return std::sqrt(double(std::max({P(v, v), P(v + 1, v + 1), P(v + 2, v + 2)})));
  }

  double unknown_sigma_;
  double sigma_;                        ///< of the latest state, inflated [m/s]
  double solved_sigma_ = 0;             ///< largest axis, of the last state solved with the window [m/s]
  double speed_ = 0, speed_sigma_ = 0;  ///< of that state [m/s]
};

}  // namespace plumbline
