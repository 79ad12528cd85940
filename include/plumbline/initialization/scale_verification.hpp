#pragma once
/// Verification of the scale after initialization without depth: the scale converges, or images and IMU contradict each
/// other and the initialization is rejected.                                        docs/math/inertial_window.md (1e)

#include <algorithm>

namespace plumbline {

struct ScaleVerificationOptions {
  /// Shortest time from initialization to convergence [s]; tuned: docs/decisions/007.
  double min_s = 3;
  /// Largest relative sigma of the speed at convergence; tuned: docs/decisions/007.
  double max_speed_sigma = 0.02;
  double speed_noise = 0.01;           ///< sigma that suffices for a slow body [m/s]; tuned: docs/decisions/007
  double max_slow_speed_sigma = 0.05;  ///< largest relative sigma of a slow body's speed; tuned: docs/decisions/007
  /// Time of contradiction within min_s after which the scale is rejected [s]; tuned: docs/decisions/008.
  double max_disagreement_s = 0.5;
};

class ScaleVerification {
 public:
  ScaleVerification() = default;
  explicit ScaleVerification(const ScaleVerificationOptions& options) : options_(options) {}

  /// Initialization is complete: starts the verification.
  void begin() {
    inconsistent_s_ = 0;
    converged_ = false;
  }
  /// Adds a frame, age_s after the initialization and dt_s after the previous frame [s]. `inconsistent`: images and IMU
  /// disagree. Speed with its sigma in [m/s].
  void update(double age_s, double dt_s, bool inconsistent, double speed, double speed_sigma) {
    if (converged_) return;
    const bool is_recent = age_s < options_.min_s;
    if (is_recent && inconsistent) inconsistent_s_ += dt_s;
    converged_ = !is_recent && determines_scale(speed, speed_sigma);
  }

  bool has_converged() const { return converged_; }
  /// Whether the initialization is to be rejected.
  bool is_rejected() const { return inconsistent_s_ > options_.max_disagreement_s; }

 private:
  /// Whether the speed, and with it the scale, is accurate enough (1e).
  bool determines_scale(double speed, double sigma) const {
    return sigma < std::min(std::max(options_.max_speed_sigma * speed, options_.speed_noise),
                            options_.max_slow_speed_sigma * speed);
  }

  ScaleVerificationOptions options_;
  double inconsistent_s_ = 0;
  bool converged_ = false;
};

/// For rigs whose scale needs no verification: no state, no code.
struct NoScaleVerification {
  static void begin() {}
  static constexpr bool has_converged() { return true; }
  static constexpr bool is_rejected() { return false; }
};

}  // namespace plumbline
