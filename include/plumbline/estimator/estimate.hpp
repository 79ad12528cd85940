#pragma once
/// The estimate that is published for a frame: pose, covariance, velocity, biases and health.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class S>
struct Estimate {
  TimeNs t_ns = 0;                             ///< time stamp of the image, as given
  double time_offset_s = 0;                    ///< rigs with an IMU: t_imu = t_image + offset [s]
  SE3<S> T_body_cam;                           ///< extrinsics in force, as estimated online
  SE3<S> T_world_body;                         ///< pose; without an IMU the body is the camera
  Mat<S, 6, 6> covariance = identity<S, 6>();  ///< of [dphi, dp], right increments [rad, m]
  Vec<S, 3> v_world_body = zeros<S, 3>();      ///< velocity in the world; rigs with an IMU [m/s]
  Vec<S, 3> bias_gyro = zeros<S, 3>();         ///< gyroscope bias [rad/s]
  Vec<S, 3> bias_accel = zeros<S, 3>();        ///< accelerometer bias [m/s^2]
  Health health;
  int tracked = 0;  ///< landmarks with depth that support the pose
  bool keyframe = false;
  std::uint32_t resets = 0;  ///< number of resets after which position or heading are uncertain
};

}  // namespace plumbline
