#pragma once
/// Continuous-time noise of an IMU, as in Kalibr and in sensor.yaml of EuRoC.

namespace plumbline {

struct ImuNoise {
  double gyro_density = 1.7e-4;   ///< white noise of the gyroscope [rad/s/sqrt(Hz)]; sensor: ADIS16448 of EuRoC
  double accel_density = 2.0e-3;  ///< white noise of the accelerometer [m/s^2/sqrt(Hz)]; sensor: ADIS16448 of EuRoC
  double gyro_walk = 2.0e-5;      ///< random walk of the gyroscope bias [rad/s^2/sqrt(Hz)]; sensor: ADIS16448 of EuRoC
  /// Random walk of the accelerometer bias [m/s^3/sqrt(Hz)]; sensor: ADIS16448 of EuRoC.
  double accel_walk = 3.0e-3;
  double rate_hz = 200;  ///< rate of the samples [Hz]; sensor: ADIS16448 of EuRoC
};

}  // namespace plumbline
