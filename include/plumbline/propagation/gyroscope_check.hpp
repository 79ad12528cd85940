#pragma once
/// Detector of a jump of the gyroscope bias: the rotation of images and gyroscope differ by a constant rate.
///                                                                                docs/math/inertial_window.md
///   m <- m + alpha (log(R_predicted^T R_images)/dt - m),   alpha = dt/rate_error_s                            (1c)
/// with the variance s^2 <- (1 - alpha)^2 s^2 + alpha^2 3 sigma_R^2/dt^2. A jump is detected when |m| exceeds
/// max_rate_error and rate_error_sigmas * s. For jump_hold_s after a jump none is detected.

#include <algorithm>
#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct GyroscopeCheckOptions {
  double max_rate_error = 0.025;  ///< smallest jump that is detected [rad/s]; tuned: docs/decisions/014
  double rate_error_s = 0.3;      ///< time constant of the mean m [s]; tuned: docs/decisions/014
  double rate_error_sigmas = 12;  ///< smallest jump in sigmas of the mean; tuned: docs/decisions/014
  double jump_hold_s = 3;         ///< time after a jump without another detection [s]; tuned: docs/decisions/014
};

template <class S>
class GyroscopeCheck {
 public:
  explicit GyroscopeCheck(const GyroscopeCheckOptions& options) : options_(options) {}

  /// Adds the time dt [s] since the previous frame.
  void advance(S dt) { since_jump_s_ += double(dt); }
  /// Adds the rotation of a frame by its images against the prediction, log(R_predicted^T R_images) [rad], with the
  /// variance of one axis [rad^2], dt > 0. True when the bias has jumped, by -rate_error().
  bool update(const Vec<S, 3>& rotation_error, S variance, S dt) {
    const S alpha = std::min(S(1), dt / S(options_.rate_error_s)), beta = S(1) - alpha;
    rate_error_ += alpha * Vec<S, 3>(rotation_error / dt - rate_error_);
    rate_variance_ = beta * beta * rate_variance_ + alpha * alpha * 3 * variance / (dt * dt);
    const S bound = S(options_.rate_error_sigmas) * std::sqrt(rate_variance_);
    const S error = norm(rate_error_);
    suspect_ = error > std::max(S(options_.max_rate_error), bound / S(2));
    return !has_recent_jump() && error > std::max(S(options_.max_rate_error), bound);
  }
  /// The bias has been corrected: restarts the mean.
  void reset_after_jump() {
    set_zero(rate_error_);
    since_jump_s_ = 0;
  }

  /// m: angular rate by the images less that of the gyroscope [rad/s].
  const Vec<S, 3>& rate_error() const { return rate_error_; }
  /// Upper bound of the rotation error of the frames since the jump [rad].       docs/math/inertial_window.md (1g)
  S gyro_jump_rotation() const { return S(2 * options_.rate_error_s) * norm(rate_error_); }
  /// Whether |m| exceeds max_rate_error and half of rate_error_sigmas * s.
  bool is_suspect() const { return suspect_; }
  bool has_recent_jump() const { return since_jump_s_ < options_.jump_hold_s; }

 private:
  GyroscopeCheckOptions options_;
  Vec<S, 3> rate_error_ = zeros<S, 3>();
  S rate_variance_ = S(0);
  double since_jump_s_ = std::numeric_limits<double>::infinity();
  bool suspect_ = false;
};

}  // namespace plumbline
