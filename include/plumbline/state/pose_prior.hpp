#pragma once
/// A belief about a frame's pose before its features are used.

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

/// About the pose that is predicted; `valid` is false where nothing is believed.
template <class S>
struct PosePrior {
  bool valid = false;
  Vec<S, state::Pose::dim> sigma = zeros<S, state::Pose::dim>();  ///< of [dphi, dp] [rad, m]
};

}  // namespace plumbline
