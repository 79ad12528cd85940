#pragma once
/// Options of map/local_bundle_adjustment.hpp.

#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

struct LocalBundleAdjustmentOptions {
  /// Iterations, damping, end. Wrong observations let the cost fall slowly for long, but poses do not move any more.
  LevenbergMarquardtOptions levenberg_marquardt{.max_iterations = 10, .relative_cost_tolerance = 1e-4};
  /// 95 % quantiles of chi-square. Beyond them the kernel is linear, and an observation is no inlier.
  double chi2_two_rows = 5.991;  ///< of bearings, segments and points on lines: 2 degrees of freedom
  double chi2_range = 3.841;     ///< 1 degree of freedom
};

}  // namespace plumbline
