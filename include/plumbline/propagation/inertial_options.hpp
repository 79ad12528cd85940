#pragma once
/// Options of the propagation of a rig with an IMU: noise inflation, gates, detection of a stationary body.

#include <algorithm>

#include "plumbline/imu/stationarity.hpp"
#include "plumbline/propagation/accelerometer_check.hpp"
#include "plumbline/propagation/gyroscope_check.hpp"
#include "plumbline/propagation/imu_factors.hpp"
#include "plumbline/state/camera_imu_filter.hpp"

namespace plumbline {

struct InertialOptions : ImuFactorOptions {
  /// Factor on the calibrated gyroscope noise density, for scale and alignment errors. Vibration is measured;
  /// tuned: docs/decisions/003.
  double gyro_inflation = 2;
  /// Accelerometer noise density in use [m/s^2/sqrt(Hz)], within the two limits below; tuned: docs/decisions/003.
  double accel_error = 6e-3;
  /// Smallest and largest factor on the calibrated accelerometer noise density; tuned: docs/decisions/003.
  double min_accel_inflation = 2, max_accel_inflation = 5;
  /// Factor on the random walks of both biases; tuned: docs/decisions/003.
  double walk_inflation = 2;
  /// Sigma of the predicted velocity where the window does not determine it [m/s]; tuned: docs/decisions/130 (chosen).
  double velocity_sigma = 0.1;
  /// Factor on the velocity sigma of the window, which is too small; tuned: docs/decisions/012.
  double velocity_inflation = 3;
  /// Sigma of the rotation since the last frame, in addition to the gyroscope noise [rad];
  /// tuned: docs/decisions/130 (chosen).
  double rotation_sigma = 5e-3;
  /// Gate of RANSAC consensus: a pose farther from the prediction is taken only if no nearer one has inliers [sigma];
  /// tuned: docs/decisions/012.
  double consensus_gate = 2;
  /// Duration of the last samples before an image that give the angular rate at the image [s];
  /// tuned: docs/decisions/028.
  double rate_window_s = 0.02;
  /// Gate of the pose by the images about the IMU prediction [sigma]; tuned: docs/decisions/130 (chosen).
  double innovation_gate = 8;
  /// The same gate while a gyroscope bias jump is recent [sigma]; tuned: docs/decisions/014.
  double innovation_gate_after_jump = 4;
  /// Mean squared whitened residual of the IMU factors beyond which images and IMU disagree (ImuFactors::disagreement).
  /// It is about 1 on a vibrating drone; tuned: docs/decisions/010.
  double max_disagreement = 4;
  /// Smallest full scale of a usable accelerometer, in units of gravity; tuned: docs/decisions/005.
  double min_full_scale = 1.1;
  /// Largest mean motion of the landmarks of a stationary body since the last keyframe [px]; tuned: docs/decisions/011.
  double stationary_motion_px = 0.5;
  /// Duration of the comparison before a body counts as stationary [s]; tuned: docs/decisions/011.
  double stationary_check_s = 0.3;
  /// Factor on the limits of stationarity for a body at rest; tuned: docs/decisions/130 (chosen).
  double stationary_hysteresis = 2;
  /// Longest factor of a stationary body [s]. Then a new one starts; tuned: docs/decisions/011.
  double max_stationary_factor_s = 2;
  GyroscopeCheckOptions gyro_check;
  AccelerometerCheckOptions accel_check;
  StationarityOptions stationarity;
  CameraImuOptions camera_imu;

  ImuNoise inflated(ImuNoise noise) const {
    noise.gyro_density *= gyro_inflation;
    noise.accel_density =
        std::clamp(accel_error, min_accel_inflation * noise.accel_density, max_accel_inflation * noise.accel_density);
    noise.gyro_walk *= walk_inflation;
    noise.accel_walk *= walk_inflation;
    return noise;
  }
};

}  // namespace plumbline
