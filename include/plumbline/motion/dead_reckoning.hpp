#pragma once
/// Where a body is while its readings alone tell, from a state that was known; and, once they have told for too long or
/// do not, how far it may have gone.                                                  docs/math/initialization.md (9)

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/state/origin.hpp"

namespace plumbline {

struct DeadReckoningOptions {
  double max_s = 3;            ///< after it velocity and place are anything
  double velocity_walk = 0.1;  ///< of readings with biases and a vertical in doubt [m/sqrt(s)]
  double rate_error = 5e-3;    ///< of the gyroscope's bias [rad/s]
  double lost_speed = 1;       ///< of a body that nothing tells of, sigma [m/s]
  double lost_rate = 1;        ///< the same of its rotation, where the gyroscope is silent as well [rad/s]
};

template <class S>
class DeadReckoning {
 public:
  using Covariance = Mat<S, 6, 6>;

  explicit DeadReckoning(const DeadReckoningOptions& options = {}) : options_(options) {}

  /// The body is at x, known that well [rad, m], and its velocity with a sigma [m/s].
  void begin(const NavState<S>& x, const Covariance& P, S velocity_sigma) {
    x_ = x;
    P_ = P;
    velocity_sigma_ = velocity_sigma;
    since_s_ = S(0);
    begun_ = true;
    lost_ = counted_ = false;
  }
  /// From now on its velocity is anything; whoever says so has counted the loss.
  void lose() { lost_ = counted_ = true; }

  /// The readings of the time dt since the last frame; those that are `blind` do not tell of the translation, `missing`
  /// ones of nothing.
  void advance(const ImuIncrement<S>& increment, const Vec<S, 3>& gravity, S dt, bool blind, bool missing) {
    if (!begun_) return;
    const S before_s = since_s_;
    since_s_ += dt;
    lost_ = lost_ || blind || missing || !(since_s_ < S(options_.max_s));
    NavState<S> x = increment.predict(x_, gravity);
    if (lost_) {
      const SO3<S> R = missing ? x_.T_world_body.rotation() : x.T_world_body.rotation();
      x = x_;
      x.T_world_body = SE3<S>(R, x_.T_world_body.p());
    }
    P_ = carried(P_, x_.T_world_body, x.T_world_body);
    x_ = x;
    const S grown = since_s_ * since_s_ - before_s * before_s, walk = S(options_.velocity_walk);
    const S rate = S(missing ? options_.lost_rate : options_.rate_error);
    const S speed = lost_ ? S(options_.lost_speed) : velocity_sigma_;
    for (int k = 0; k < 3; ++k) {
      P_(k, k) += rate * rate * grown;
      P_(3 + k, 3 + k) += speed * speed * grown + walk * walk * dt;
    }
  }

  /// True once after the body was lost, for who counts.
  bool count_loss() {
    const bool counts = lost_ && !counted_;
    counted_ = counted_ || lost_;
    return counts;
  }

  /// Whether a body that is said to be at p, with a sigma [m], cannot be there, or nothing is known so badly here.
  bool outweighs(const Vec<S, 3>& p, S sigma) const {
    const S known = std::sqrt(P_(3, 3)), most = S(3) * std::hypot(sigma, known);
    const bool excludes = !lost_ && !(norm(Vec<S, 3>(p - x_.T_world_body.p())) <= most);
    return begun_ && (excludes || !(sigma <= S(2) * known));
  }

  bool has_begun() const { return begun_; }
  bool is_lost() const { return lost_; }
  const NavState<S>& state() const { return x_; }
  const Covariance& covariance() const { return P_; }

 private:
  DeadReckoningOptions options_;
  NavState<S> x_;
  Covariance P_ = zeros<Covariance>();
  S velocity_sigma_ = S(0), since_s_ = S(0);
  bool begun_ = false, lost_ = false, counted_ = false;
};

}  // namespace plumbline
