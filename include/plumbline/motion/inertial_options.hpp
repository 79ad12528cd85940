#pragma once
/// What the motion of a rig with an IMU takes for granted of its sensors and of what it sees.

#include <algorithm>

#include "plumbline/imu/standstill.hpp"
#include "plumbline/motion/accelerometer_check.hpp"
#include "plumbline/motion/gyroscope_check.hpp"
#include "plumbline/motion/inertial_links.hpp"
#include "plumbline/state/camera_imu_filter.hpp"

namespace plumbline {

struct InertialOptions : InertialLinkOptions {
  double gyro_inflation = 2;  ///< of the calibrated density: scale and alignment errors; vibration is measured
  double accel_error = 6e-3;  ///< the same of an accelerometer, whatever its density [m/s^2/sqrt(Hz)],
  double min_accel_inflation = 2, max_accel_inflation = 5;  ///< but so many times the density
  double walk_inflation = 2;
  double velocity_sigma = 0.1;    ///< of the velocity that predicts a frame, where the window does not tell [m/s]
  double velocity_doubt = 3;      ///< the window's own is so much too small
  double rotation_sigma = 5e-3;   ///< of the rotation since the last frame, beside the gyroscope's noise [rad]
  double max_vote = 2;            ///< no pose farther from the prediction is taken where a nearer one has votes [sigma]
  double rate_s = 0.02;           ///< readings of so long before an image tell how the body turns, and its rows with it
  double max_innovation = 8;      ///< of a frame's pose by its images against the readings [sigma]
  double doubted_innovation = 4;  ///< the same once another bias was found, which is to explain what is seen
  double max_disagreement = 4;    ///< of readings and images, see InertialLinks; about 1 on a vibrating drone
  double min_full_scale = 1.1;    ///< of an accelerometer that tells anything [gravity]
  double rest_motion_px = 0.5;    ///< landmarks that moved less since the last keyframe do not contradict a standstill
  double rest_check_s = 0.3;      ///< they are watched for so long
  double rest_hysteresis = 2;     ///< limits are this much wider for a body at rest
  double max_rest_link_s = 2;     ///< a standstill goes on for ever, its readings are of use for so long
  GyroscopeCheckOptions gyro_check;
  AccelerometerCheckOptions accel_check;
  StandstillOptions standstill;
  CameraImuOptions camera_imu;

  ImuNoise inflated(ImuNoise noise) const {
    noise.gyro_density *= gyro_inflation;
    noise.accel_density =
        std::clamp(accel_error, min_accel_inflation * noise.accel_density, max_accel_inflation * noise.accel_density);
    noise.gyro_walk *= walk_inflation;
    noise.accel_walk *= walk_inflation;
    return noise;
  }
};

}  // namespace plumbline
