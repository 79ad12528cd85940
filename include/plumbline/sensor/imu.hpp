#pragma once
/// The inertial sensor of a rig. Its frame is the body frame.

#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct Imu {
  static constexpr bool is_present = true;

  SE3<double> T_body_cam;           ///< camera to body coordinates
  ImuNoise noise;                   ///< as calibrated; the estimator inflates it, see InertialOptions
  ImuBufferOptions limits;          ///< what the sensor can measure
  double camera_time_offset_s = 0;  ///< time of the IMU's clock = time stamp of the image + offset
};

}  // namespace plumbline
