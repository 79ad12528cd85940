#pragma once
/// After the start of a camera without depth: until readings and images have told the scale for some time, and well, it
/// may still be wrong; what they say of each other tells whether it is.            docs/math/inertial_window.md (1e)

#include <algorithm>

namespace plumbline {

struct SettlingOptions {
  double min_s = 3;                    ///< after the start the scale is not certain,
  double max_speed_sigma = 0.02;       ///< nor before the window has known a speed that well, relative,
  double speed_noise = 0.01;           ///< or, of a slow body, as well as that [m/s],
  double max_slow_speed_sigma = 0.05;  ///< but no worse than that, relative
  double max_disagreement_s = 0.5;     ///< readings and images that contradict each other for longer in that time
};

class Settling {
 public:
  Settling() = default;
  explicit Settling(const SettlingOptions& options) : options_(options) {}

  /// A start is complete.
  void begin() {
    disagreed_s_ = 0;
    is_certain_ = false;
  }
  /// A frame so long after that, and after the frame before [s]: whether readings and images disagree, and the speed
  /// with its sigma [m/s].
  void see(double age_s, double dt_s, bool disagree, double speed, double speed_sigma) {
    if (is_certain_) return;
    const bool young = age_s < options_.min_s;
    if (young && disagree) disagreed_s_ += dt_s;
    is_certain_ = !young && tells_scale(speed, speed_sigma);
  }

  bool is_certain() const { return is_certain_; }
  /// Whether the start was none.
  bool is_refuted() const { return disagreed_s_ > options_.max_disagreement_s; }

 private:
  /// (1e)
  bool tells_scale(double speed, double sigma) const {
    return sigma < std::min(std::max(options_.max_speed_sigma * speed, options_.speed_noise),
                            options_.max_slow_speed_sigma * speed);
  }

  SettlingOptions options_;
  double disagreed_s_ = 0;
  bool is_certain_ = false;
};

}  // namespace plumbline
