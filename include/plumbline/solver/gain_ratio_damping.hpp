#pragma once
/// Damping mu of Levenberg-Marquardt by Nielsen's gain-ratio rule.                         docs/math/solver.md
/// (14)-(15)
///
///   g = (cost - cost of the trial) / predicted decrease                                                      (14)
///   g > 0: accept, mu *= max(1/3, 1 - (2 g - 1)^3), nu = 2;   else: reject, mu *= nu, nu *= 2                (15)

#include <algorithm>

#include "plumbline/core/elementary.hpp"

namespace plumbline {

struct GainRatioDamping {
  double mu = 0;
  double nu = 2;  ///< factor of mu at the next rejection

  /// A step that lowered the cost by `decrease` > 0. mu stays at mu_min or above.
  void accept(double decrease, double predicted_decrease, double mu_min) {
    const double gain = decrease / predicted_decrease;                                    // (14)
    mu = std::max(mu_min, mu * std::max(1.0 / 3, 1 - elementary::pow(2 * gain - 1, 3)));  // (15)
    nu = 2;
  }
  void reject() {
    mu *= nu;
    nu *= 2;
  }
};

}  // namespace plumbline
