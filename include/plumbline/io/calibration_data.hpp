#pragma once
/// What is known of a camera and an IMU before the first frame.                 docs/guide/your_recording.md

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::io {

struct CameraCalibration {
  std::string model = "pinhole";    ///< pinhole, double_sphere, omni, eucm
  std::string distortion = "none";  ///< none, radtan, rational, equidistant, fov
  /// fx fy cx cy [px]; double_sphere: then xi alpha; omni: then xi; eucm: then alpha beta.
  std::vector<double> intrinsics;
  /// radtan: k1 k2 p1 p2 (k3); rational: k1 k2 p1 p2 k3 k4 k5 k6; equidistant: k1 k2 k3 k4; fov: w.
  std::vector<double> distortion_coefficients;
  int width = 0, height = 0;        ///< [px]
  double rate_hz = 0;               ///< 0: not stated
  std::optional<double> readout_s;  ///< of a rolling shutter, first to last row; 0: global shutter
};

struct Calibration {
  CameraCalibration camera;
  std::optional<SE3<double>> T_body_camera;  ///< camera into body (= IMU) coordinates
  std::optional<ImuNoise> imu;
  ImuBufferOptions imu_limits;      ///< full scales, where stated
  double depth_scale = 0;           ///< raw depth units per meter; 0: no depth
  double camera_time_offset_s = 0;  ///< t_imu = t_image + offset
  double image_scale = 1;           ///< of the images beside those of the camera; `camera` describes the scaled ones
  /// Gray image of the size of the camera's, before they are scaled; where it is zero the images do not show the scene.
  std::optional<std::filesystem::path> mask;
  std::vector<std::string> notes;  ///< one line each: what the file states and is not used, what was taken for what
};

}  // namespace plumbline::io
