#pragma once
/// Continuous-time noise of an inertial sensor, as Kalibr and EuRoC's sensor.yaml state it.

namespace plumbline {

struct ImuNoise {
  double gyro_density = 1.7e-4;   ///< [rad/s/sqrt(Hz)]
  double accel_density = 2.0e-3;  ///< [m/s^2/sqrt(Hz)]
  double gyro_walk = 2.0e-5;      ///< [rad/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;     ///< [m/s^3/sqrt(Hz)]
  double rate_hz = 200;           ///< [Hz]
};

}  // namespace plumbline
