#pragma once
/// What is wrong with a simulated recording, as with recordings from the field.

#include <vector>

#include "plumbline/imu/sample.hpp"
#include "plumbline/lie/so3.hpp"

struct SimulateFaults {
  double noise_factor = 1;                  ///< white noise of the IMU by that which the calibration states
  double gyro_range = 0, accel_range = 0;   ///< samples are limited to it [rad/s], [m/s^2]; 0: unlimited
  std::vector<double> vibration;            ///< of the accelerometer: rms [m/s^2] and frequency [Hz]; empty: none
  bool accel_sign = false;                  ///< of the accelerometer is reversed
  int held_accel = 1;                       ///< the accelerometer repeats each value in so many rows
  int bursts = 1;                           ///< so many IMU samples have stamps of arrival, 0.1 ms apart
  std::vector<double> extrinsics_turn_deg;  ///< rotation vector, in the camera, of the stated transform; empty: none
  double stated_depth_scale = 1000;         ///< raw units per meter; true: 1000
  double bonnet = 0;                        ///< lower part of the images that shows the vehicle

  bool has_depth_fault() const { return stated_depth_scale != 1000; }
  plumbline::SO3<double> extrinsics_turn() const;
};

/// Makes samples faulty, one after the other.
class ImuFaults {
 public:
  explicit ImuFaults(const SimulateFaults& faults) : faults_(faults) {}
  /// `period_ns`: between true samples.
  plumbline::ImuSample operator()(plumbline::ImuSample sample, plumbline::TimeNs period_ns);

 private:
  SimulateFaults faults_;
  plumbline::Vec<double, 3> held_ = plumbline::Vec<double, 3>::Zero();
  int count_ = 0;
};
