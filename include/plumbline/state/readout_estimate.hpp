#pragma once
/// Estimate of the readout time of a rolling shutter.                             docs/math/rolling_shutter.md
///
/// The value in use follows the estimate, unless it is held (a camera assumed to have a global shutter): a held value
/// is kept until the estimate differs from it significantly.

#include <algorithm>
#include <cmath>

#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

struct ReadoutOptions {
  double max_s = 0.05;  ///< largest readout time [s]; frame rate: one frame at 20 Hz
  /// Smallest difference to the estimate beyond which a held value is released [s]; tuned: docs/decisions/036.
  double min_change_s = 6e-3;
  /// The same in sigmas of the estimate; both must be exceeded; tuned: docs/decisions/036.
  double min_change_sigmas = 5;
};

template <class S>
class ReadoutEstimate {
 public:
  ReadoutEstimate() = default;
  ReadoutEstimate(const Readout<S>& prior, const ReadoutOptions& options)
      : options_(options), readout_(prior), found_s_(prior.value_s) {}

  /// Value in use with its sigma.
  const Readout<S>& readout() const { return readout_; }
  /// Estimate, also while the value in use is held [s].
  S found_s() const { return found_s_; }

  /// Adds a correction with its sigma [s]; no change if either is not finite or the readout time is known.
  void correct(S correction_s, S sigma_s) {
    if (readout_.is_known() || !std::isfinite(correction_s) || !(sigma_s > S(0))) return;
    found_s_ = std::clamp(readout_.value_s + correction_s, S(0), S(options_.max_s));
    readout_.sigma_s = sigma_s;
    const S least = std::max(S(options_.min_change_s), S(options_.min_change_sigmas) * sigma_s);
    readout_.is_held = readout_.is_held && !(std::abs(found_s_ - readout_.value_s) > least);
    if (!readout_.is_held) readout_.value_s = found_s_;
  }

 private:
  ReadoutOptions options_;
  Readout<S> readout_;
  S found_s_ = S(0);
};

}  // namespace plumbline
