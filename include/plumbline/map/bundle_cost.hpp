#pragma once
/// Cost of the observations of one landmark, and the longest of its steps that keeps them valid.
///                                                                              docs/math/local_bundle_adjustment.md

#include <array>

namespace plumbline {

struct BundleCost {
  double cost = 0;
  bool is_valid = true;  ///< all observations
  void add(double rho, bool valid) {
    cost += rho / 2;
    is_valid = is_valid && valid;
  }
};

/// The cost of `trial(share)` of the whole step, or of less where that would take the landmark out of the view of its
/// cameras: it would hold up all others.
inline double cost_of_valid_step(auto&& trial) {
  BundleCost out = trial(1.0);
  for (const double share : std::array{0.25, 0.0625, 0.0}) {
    if (out.is_valid) break;
    out = trial(share);
  }
  return out.cost;
}

}  // namespace plumbline
