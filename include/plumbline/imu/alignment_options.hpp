#pragma once
/// Options of the visual-inertial alignment (imu/alignment.hpp).

#include <cstddef>

namespace plumbline {

struct InertialAlignmentOptions {
  bool metric = false;           ///< the positions of the camera poses are in meters; set by the initializer
  double rotation_sigma = 2e-3;  ///< sigma of the rotation of a camera pose [rad]; tuned: docs/decisions/132 (chosen)
  /// Sigma of the position of a camera pose besides its own covariance, in units of the poses;
  /// tuned: docs/decisions/023.
  double position_sigma = 2e-3;
  double accel_bias_sigma = 0.2;  ///< prior sigma of the accelerometer bias [m/s^2]; tuned: docs/decisions/024
  std::size_t min_frames = 5;     ///< smallest number of frames; numerics: 4 determine the unknowns
  /// Largest rms rotation between camera and gyroscope after the bias is estimated [rad];
  /// tuned: docs/decisions/132 (chosen).
  double max_gyro_residual = 0.02;
  double max_chi2 = 3;  ///< largest chi2 per degree of freedom; below 1 for consistent poses; tuned: docs/decisions/023
  /// Largest error of the norm of free gravity, relative, besides three of its sigmas;
  /// tuned: docs/decisions/132 (chosen).
  double max_gravity_error = 0.1;
  double max_gravity_sigma = 0.05;  ///< largest sigma of the direction of gravity [rad]; tuned: docs/decisions/023
  double max_scale_sigma = 0.1;     ///< largest sigma of the scale, relative; tuned: docs/decisions/023
};

}  // namespace plumbline
