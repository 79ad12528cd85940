#pragma once
/// What the estimator publishes for a frame.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class S>
struct Estimate {
  TimeNs t_ns = 0;                             ///< of the image, as it was given
  double time_offset_s = 0;                    ///< rigs with an IMU: it was taken so much later on its clock
  SE3<S> T_body_cam;                           ///< where the camera sits, as far as it was found out
  SE3<S> T_world_body;                         ///< body = camera where there is no IMU
  Mat<S, 6, 6> covariance = identity<S, 6>();  ///< of [dphi, dp], right increments [rad, m]
  Vec<S, 3> v_world_body = zeros<S, 3>();      ///< rigs with an IMU [m/s]
  Vec<S, 3> bias_gyro = zeros<S, 3>();         ///< [rad/s]
  Vec<S, 3> bias_accel = zeros<S, 3>();        ///< [m/s^2]
  Health health;
  int tracked = 0;  ///< located landmarks that support the pose
  bool keyframe = false;
  std::uint32_t resets = 0;  ///< how often the estimator had to start anew
};

}  // namespace plumbline
