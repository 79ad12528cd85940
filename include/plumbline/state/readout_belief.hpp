#pragma once
/// What is believed of the readout time of a rolling shutter.                     docs/math/rolling_shutter.md
///
/// What is found is the readout; a value that is held (a camera taken for one with a global shutter) stays until what
/// is found is beyond doubt another.

#include <algorithm>
#include <cmath>

#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

struct ReadoutOptions {
  double max_s = 0.05;
  double doubt_s = 6e-3;    ///< a value that is held gives way to one that differs by more,
  double doubt_sigmas = 5;  ///< and by so many sigma
};

template <class S>
class ReadoutBelief {
 public:
  ReadoutBelief() = default;
  ReadoutBelief(const Readout<S>& prior, const ReadoutOptions& options)
      : options_(options), readout_(prior), found_s_(prior.value_s) {}

  const Readout<S>& readout() const { return readout_; }
  S found_s() const { return found_s_; }

  /// It is found to be wrong by `correction_s`, with a sigma; no change when that is no number.
  void correct(S correction_s, S sigma_s) {
    if (readout_.is_known() || !std::isfinite(correction_s) || !(sigma_s > S(0))) return;
    found_s_ = std::clamp(readout_.value_s + correction_s, S(0), S(options_.max_s));
    readout_.sigma_s = sigma_s;
    const S doubt = std::max(S(options_.doubt_s), S(options_.doubt_sigmas) * sigma_s);
    readout_.is_held = readout_.is_held && !(std::abs(found_s_ - readout_.value_s) > doubt);
    if (!readout_.is_held) readout_.value_s = found_s_;
  }

 private:
  ReadoutOptions options_;
  Readout<S> readout_;
  S found_s_ = S(0);
};

}  // namespace plumbline
