#pragma once
/// Estimate of the time offset of the camera by CameraImuFilter.                      docs/math/camera_imu.md

namespace plumbline {

struct TimeOffsetEstimate {
  double offset_s = 0;      ///< t_imu = t_image + offset [s]
  double sigma_s = 0;       ///< sigma of the offset if it was corrected [s]; 0: it is that of the calibration
  bool is_known = true;     ///< the offset is fixed: it is not estimated
  bool is_suspect = false;  ///< the estimate differs from it, not significantly enough for a correction
};

}  // namespace plumbline
