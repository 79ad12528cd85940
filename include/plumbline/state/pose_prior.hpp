#pragma once
/// Prior on the pose of a frame from its prediction, before its features are used.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

/// Standard deviations about the predicted pose; `valid` is false where there is no prior.
template <class S>
struct PosePrior {
  bool valid = false;
  Vec<S, state::Pose::dim> sigma = zeros<S, state::Pose::dim>();  ///< sigma of [dphi, dp] [rad, m]

  /// Whether the innovation d = [dphi, dp], pose minus predicted pose, is within `max_sigmas` on every axis; false for
  /// NaN.
  bool passes_gate(const Vec<S, state::Pose::dim>& d, S max_sigmas) const {
    if (!valid) return true;
    for (int k = 0; k < state::Pose::dim; ++k) {
      if (!(std::abs(d[k]) <= max_sigmas * sigma[k])) return false;
    }
    return true;
  }
};

}  // namespace plumbline
