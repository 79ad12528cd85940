#pragma once
/// The IMU factor of a frame: the samples since an earlier frame, and what is known about them.
///                                                                                docs/math/inertial_window.md

#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/imu_intervals.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/propagation/camera_time_offset.hpp"

namespace plumbline {

struct ImuFactorOptions {
  double gravity = standard_gravity<double>;  ///< magnitude of gravity [m/s^2]; geometry: mid-latitudes
  /// Sigma of the velocity of a stationary body [m/s]; tuned: docs/decisions/130 (chosen).
  double zero_velocity_sigma = 0.01;
  /// Sigma of the rotation between stationary frames [rad]; tuned: docs/decisions/130 (chosen).
  double stationary_rotation_sigma = 2e-3;
  /// Sigma of the translation between stationary frames [m]; tuned: docs/decisions/130 (chosen).
  double stationary_position_sigma = 2e-3;
  /// Sigma of a suspect accelerometer over one second [m/s^2]; tuned: docs/decisions/015.
  double suspect_accel_sigma = 20;
  /// Sigma of the change of the gyroscope bias at a jump [rad/s]; sensor: zero-rate offset of MEMS, about 10 deg/s.
  double jump_gyro_bias = 0.2;
};

/// The IMU factor of a frame to the frame in slot `previous`, -1 for none.
template <class S>
struct ImuFactor {
  int previous = -1;
  ImuIntervals<S> samples;                 ///< between the two frames
  ImuNoise noise = {};                     ///< of the samples
  bool is_stationary = false;              ///< the body is at rest since the previous frame
  bool jumped = false;                     ///< the gyroscope bias has jumped since the previous frame
  SampleBoundary<S> begin = {}, end = {};  ///< boundaries of the samples
  bool is_accel_suspect = false;           ///< the accelerometer is suspect, see AccelerometerCheck
};

}  // namespace plumbline
