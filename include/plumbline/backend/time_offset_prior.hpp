#pragma once
/// What was known of the camera's clock before frames and readings were solved for together.
///                                                                                          docs/math/camera_imu.md
///   1/2 rho(e^2/sigma^2),   e the correction of the time offset, sigma at least that of a calibration            (7)
/// with Cauchy's rho, like that of the mount: it never goes into the window's prior.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

struct TimeOffsetOptions {
  double sigma_s = 5e-4;    ///< of the calibration; 0: it is known
  double doubt = 3;         ///< it is hardly believed beyond so many sigma
  double settled_s = 3e-3;  ///< less of a change than that is none,
  double settling_s = 1;    ///< and so long after one the mount of the camera is held
};

class TimeOffsetPrior {
 public:
  TimeOffsetPrior() = default;
  TimeOffsetPrior(const TimeOffsetOptions& options, double found_sigma_s)
      : sigma_(std::max(options.sigma_s, found_sigma_s)), loss_{options.doubt} {}

  double cost(double e) const { return loss_.rho(squared(e)) / 2; }
  double information(double e) const { return loss_.weight(squared(e)) / (sigma_ * sigma_); }

 private:
  double squared(double e) const { return e * e / (sigma_ * sigma_); }

  double sigma_ = 1;
  Cauchy<double> loss_{1};
};

}  // namespace plumbline
