#pragma once
/// Continuous-time noise of an IMU, as in Kalibr and in sensor.yaml of EuRoC.

namespace plumbline {

struct ImuNoise {
  double gyro_density = 1.7e-4;   ///< white noise of the gyroscope [rad/s/sqrt(Hz)]
  double accel_density = 2.0e-3;  ///< white noise of the accelerometer [m/s^2/sqrt(Hz)]
  double gyro_walk = 2.0e-5;      ///< random walk of the gyroscope bias [rad/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;     ///< random walk of the accelerometer bias [m/s^3/sqrt(Hz)]
  double rate_hz = 200;           ///< rate of the samples [Hz]
};

}  // namespace plumbline
