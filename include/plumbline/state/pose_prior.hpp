#pragma once
/// A belief about a frame's pose before its features are used.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

/// About the pose that is predicted; `valid` is false where nothing is believed.
template <class S>
struct PosePrior {
  bool valid = false;
  Vec<S, state::Pose::dim> sigma = zeros<S, state::Pose::dim>();  ///< of [dphi, dp] [rad, m]

  /// Whether a pose may be the frame's that is so far, [dphi, dp], from the predicted one; a NaN may not.
  bool admits(const Vec<S, state::Pose::dim>& d, S max_sigmas) const {
    if (!valid) return true;
    for (int k = 0; k < state::Pose::dim; ++k) {
      if (!(std::abs(d[k]) <= max_sigmas * sigma[k])) return false;
    }
    return true;
  }
};

}  // namespace plumbline
