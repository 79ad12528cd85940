#pragma once
/// What is known of the camera's clock.                                               docs/math/camera_imu.md

namespace plumbline {

struct ClockBelief {
  double offset_s = 0;    ///< time of the IMU = time of the image + offset
  double sigma_s = 0;     ///< of what was found out about it; 0: it is as it was calibrated
  bool known = true;      ///< there is nothing to find out
  bool in_doubt = false;  ///< something speaks against it, not enough to correct it
};

}  // namespace plumbline
