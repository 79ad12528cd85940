#pragma once
/// The calibration by parameters and camera_info.

#include <stdexcept>

#include "calibrated_sensors.hpp"
#include "plumbline/io/bag/camera_info.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline_ros2/parameters.hpp"
#include "runner.hpp"

namespace plumbline::ros2 {

/// Whether camera_info is needed. Throws std::invalid_argument where it cannot be enough.
inline bool needs_camera_info(const Parameters& p, const Configuration& configuration) {
  if (!p.calibration.empty()) return false;
  if (configuration.needs.imu)
    throw std::invalid_argument("parameter calibration: " + std::string(configuration.name) +
                                " needs a file: camera_info has no transform between camera and IMU");
  if (!p.imu_calibration.empty()) throw std::invalid_argument("parameter imu_calibration goes with calibration");
  return true;
}

/// `info` is used where `needs_camera_info`. Throws std::runtime_error.
inline io::Calibration calibration_of(const Parameters& p, const Configuration& configuration,
                                      const io::bag::CameraInfoMessage& info) {
  io::Calibration out;
  if (p.calibration.empty())
    out = io::bag::calibration_of("camera_info", info);
  else if (p.imu_calibration.empty())
    out = io::read_calibration(p.calibration);
  else
    out = io::read_calibration(p.calibration, p.imu_calibration);
  constexpr double millimeters = 1000;  // REP 118
  if (p.depth_scale > 0) out.depth_scale = p.depth_scale;
  if (!(out.depth_scale > 0)) out.depth_scale = millimeters;
  if (!p.mask.empty()) out.mask = p.mask;
  require_calibrated(configuration, out, p.calibration.empty() ? "camera_info" : p.calibration);
  return out;
}

}  // namespace plumbline::ros2
