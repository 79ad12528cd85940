#pragma once
/// Prior on the time offset of the camera, from calibration or CameraImuFilter.            docs/math/camera_imu.md
///
///   1/2 rho(e^2/sigma^2),   e the correction of the time offset, sigma the larger of option and filter          (7)
/// with Cauchy's rho. Like that of the extrinsics the term is never marginalized.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

struct TimeOffsetOptions {
  /// Prior sigma of a calibrated time offset [s]; 0: the offset is fixed; tuned: docs/decisions/028.
  double sigma_s = 5e-4;
  double cauchy_scale = 3;  ///< Cauchy scale [sigma]; tuned: docs/decisions/028
  /// Smallest change of the offset that counts as a correction [s]; tuned: docs/decisions/029.
  double min_change_s = 3e-3;
  /// Time for which the extrinsics are held after a correction of the offset [s]; tuned: docs/decisions/029.
  double hold_extrinsics_s = 1;
};

class TimeOffsetPrior {
 public:
  TimeOffsetPrior() = default;
  TimeOffsetPrior(const TimeOffsetOptions& options, double found_sigma_s)
      : sigma_(std::max(options.sigma_s, found_sigma_s)), loss_{options.cauchy_scale} {}

  /// (7)
  double cost(double e) const { return loss_.rho(squared(e)) / 2; }
  /// Weighted information on e [1/s^2].
  double information(double e) const { return loss_.weight(squared(e)) / (sigma_ * sigma_); }

 private:
  double squared(double e) const { return e * e / (sigma_ * sigma_); }

  double sigma_ = 1;
  Cauchy<double> loss_{1};
};

}  // namespace plumbline
