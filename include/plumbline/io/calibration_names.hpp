#pragma once
/// What is said of a file that is no calibration: the formats that are read, and those that are known and not read.

#include <string>

#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io::detail {

/// Each with a key that it is recognized by.
inline constexpr const char* read_formats =
    "plumbline (camera), Kalibr and OpenVINS (cam0, relative_config_imucam), EuRoC (camera_model), OpenCV "
    "(camera_matrix), VINS (model_type, cam0_calib), ORB-SLAM (Camera1.fx, Camera.fx), OKVIS (cameras), Basalt "
    "(value0), "
    "ROS camera_info (width, k), KITTI (P0, P_rect_00)";
inline constexpr const char* unread_formats = "DepthAI (cameraData) and Maplab (cameras with T_B_C)";

/// The name of a format that is known and not read, with what to do; empty of any other.
inline std::string unread_format(const YamlMap& root) {
  if (root.has("cameraData"))
    return "this is a calibration of DepthAI (OAK), which is not read: write its camera in another format";
  if (root.size("cameras") > 0 && root.item("cameras", 0).has("T_B_C"))
    return "this is a calibration of Maplab, which is not read: write its camera in another format";
  if (root.has("gyroscope_noise_density") || root.has("imu0"))
    return "this is the calibration of an IMU (give it with --imu-calibration)";
  if (root.has("R") && root.has("T"))
    return "this is a transform of KITTI: give calib_cam_to_cam.txt, which is read with the two others beside it";
  return {};
}

}  // namespace plumbline::io::detail
