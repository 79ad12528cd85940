#pragma once
/// A gyroscope's bias that jumps: images turn otherwise than it, for some time, always alike and beyond doubt.
///                                                                                docs/math/inertial_window.md
/// It does so once: what goes on for longer is something else.

#include <algorithm>
#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct GyroscopeCheckOptions {
  double max_rate_error = 0.025;  ///< against the images: more is another bias [rad/s]
  double rate_error_s = 0.3;      ///< mean over so long
  double rate_error_sigmas = 12;  ///< and so many sigma of that mean
  double jump_settles_s = 3;      ///< readings are in doubt for so long
};

template <class S>
class GyroscopeCheck {
 public:
  explicit GyroscopeCheck(const GyroscopeCheckOptions& options) : options_(options) {}

  void pass(S dt) { since_jump_s_ += double(dt); }
  /// The next frame: how it is turned against what was foretold [rad], with the variance of an axis [rad^2]; dt > 0.
  /// Whether the bias has jumped, by -rate_error() less.
  bool update(const Vec<S, 3>& turned, S variance, S dt) {
    const S part = std::min(S(1), dt / S(options_.rate_error_s)), rest = S(1) - part;
    rate_error_ += part * Vec<S, 3>(turned / dt - rate_error_);
    rate_variance_ = rest * rest * rate_variance_ + part * part * 3 * variance / (dt * dt);
    const S clear = S(options_.rate_error_sigmas) * std::sqrt(rate_variance_);
    const S error = norm(rate_error_);
    suspect_ = error > std::max(S(options_.max_rate_error), clear / S(2));
    return !in_doubt() && error > std::max(S(options_.max_rate_error), clear);
  }
  /// Another bias was found, which is to explain what is seen.
  void settle() {
    set_zero(rate_error_);
    since_jump_s_ = 0;
  }

  const Vec<S, 3>& rate_error() const { return rate_error_; }  ///< seen, and not read [rad/s]
  /// Since the readings err: the mean has reached the part 1 - exp(-t/rate_error_s) of a step by then, and the step has
  /// turned the body by no more than twice what that part would in rate_error_s, where t < 1.6 rate_error_s [rad].
  S turned_wrongly() const { return S(2 * options_.rate_error_s) * norm(rate_error_); }
  bool is_suspect() const { return suspect_; }  ///< or the images are
  bool in_doubt() const { return since_jump_s_ < options_.jump_settles_s; }

 private:
  GyroscopeCheckOptions options_;
  Vec<S, 3> rate_error_ = zeros<S, 3>();
  S rate_variance_ = S(0);
  double since_jump_s_ = std::numeric_limits<double>::infinity();
  bool suspect_ = false;
};

}  // namespace plumbline
