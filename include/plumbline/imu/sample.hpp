#pragma once
/// IMU sample: angular rate and specific force at one time, in the body (= IMU) frame.        docs/conventions.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"

namespace plumbline {

struct ImuSample {
  TimeNs t_ns = 0;
  Vec<double, 3> gyro = zeros<double, 3>();   ///< angular rate [rad/s]
  Vec<double, 3> accel = zeros<double, 3>();  ///< specific force [m/s^2]; (0, 0, +9.81) when stationary and level
};

}  // namespace plumbline
