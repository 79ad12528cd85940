#pragma once
/// IMU of a rig: calibration and limits. Its frame is the body frame.

#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct Imu {
  static constexpr bool is_present = true;

  SE3<double> T_body_cam;           ///< extrinsics
  ImuNoise noise;                   ///< calibrated noise; the estimator inflates it, see InertialOptions
  ImuBufferOptions limits;          ///< full scale, gaps and further limits
  double camera_time_offset_s = 0;  ///< t_imu = t_image + offset [s]
};

}  // namespace plumbline
