#pragma once
/// Options of the buffer of IMU samples (imu/imu_buffer.hpp).

namespace plumbline {

struct ImuBufferOptions {
  double gyro_full_scale = 34.9;    ///< full scale of the gyroscope [rad/s]; sensor: MEMS of 2000 deg/s
  double accel_full_scale = 156.9;  ///< full scale of the accelerometer [m/s^2]; sensor: MEMS of 16 g
  double gap_s = 0.025;             ///< samples further apart than this are a gap [s]; sensor: five samples at 200 Hz
  /// Typical rate of change of the angular rate [rad/s^2]; tuned: docs/decisions/137 (chosen).
  double gyro_rate = 10;
  /// Typical rate of change of the specific force [m/s^3]; tuned: docs/decisions/137 (chosen).
  double accel_rate = 50;
  /// Fraction of the scatter of the accelerometer that counts as noise, (8b); tuned: docs/decisions/002.
  double vibration = 0.3;
  double vibration_s = 0.5;  ///< time constant of the scatter [s]; tuned: docs/decisions/137 (chosen)
  /// Largest step of time stamps that is no clock jump [s]; tuned: docs/decisions/137 (chosen).
  double max_jump_s = 1;
  /// Repetitions of all six numbers after which a sensor counts as frozen; tuned: docs/decisions/137 (chosen).
  int frozen_samples = 25;
};

}  // namespace plumbline
