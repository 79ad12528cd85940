#pragma once
/// The calibration formats of plumbline, EuRoC and OpenCV, each a function from its YAML to a `Calibration`.

#include <string>
#include <vector>

#include "plumbline/io/calibration_checks.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io::detail {

/// How long the rows of an image take, times a key's unit; in each format `readout_s`, of the whole image.
inline void set_readout(CameraCalibration& camera, const YamlMap& map, const char* key = "readout_s", double unit = 1) {
  if (!map.has(key)) return;
  camera.readout_s = unit * map.number(key);
  if (!(*camera.readout_s >= 0 && *camera.readout_s < 0.2))
    map.fail(key, "must be from 0 to 0.2 seconds" + std::string(unit == 1 ? "" : " for all rows"));
}

/// OpenCV's list of radial-tangential coefficients is that of the rational model where k4 to k6 are there and not zero.
inline void set_rational_if_more(CameraCalibration& camera) {
  std::vector<double>& k = camera.distortion_coefficients;
  while (k.size() > 5 && k.back() == 0) k.pop_back();
  if (k.size() <= 5 || k.size() > 8) return;
  k.resize(8);
  camera.distortion = "rational";
}

/// plumbline's own: camera, depth, T_body_camera, imu.
inline Calibration read_plain(const YamlMap& root) {
  root.allow_only({"camera", "depth", "T_body_camera", "imu"});
  const YamlMap map = root.map("camera");
  map.allow_only({"model", "intrinsics", "distortion", "distortion_coefficients", "resolution", "rate_hz",
                  "time_offset_s", "readout_s", "mask"});
  Calibration out;
  CameraCalibration& camera = out.camera;
  camera.model = map.text("model");
  if (camera.model != "pinhole" && camera.model != "double_sphere" && camera.model != "omni" && camera.model != "eucm")
    map.fail("model", "is \"" + camera.model + "\"; known are pinhole, double_sphere, omni and eucm");
  camera.intrinsics = map.numbers("intrinsics");
  if (map.has("distortion")) camera.distortion = distortion_name(map, "distortion");
  if (camera.distortion != "none" || map.has("distortion_coefficients"))
    camera.distortion_coefficients = map.numbers("distortion_coefficients");
  set_resolution(camera, map, "resolution");
  camera.rate_hz = map.number_or("rate_hz", frame_rate_range, 0);
  check_projection(camera, map, "intrinsics", "resolution");
  check_distortion(camera, map, map.has("distortion_coefficients") ? "distortion_coefficients" : "model");
  if (map.has("time_offset_s")) out.camera_time_offset_s = map.number("time_offset_s", time_offset_range);
  set_readout(camera, map);
  if (map.has("mask")) out.mask = root.file().parent_path() / map.text("mask");
  if (root.has("depth")) {
    const YamlMap depth = root.map("depth");
    depth.allow_only({"scale"});
    out.depth_scale = depth.number("scale", depth_scale_range);
  }
  if (root.has("imu")) {
    const YamlMap imu = root.map("imu");
    imu.allow_only({"rate_hz", "gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density",
                    "accelerometer_random_walk", "gyroscope_full_scale", "accelerometer_full_scale"});
    set_imu(out, imu, "rate_hz");
  }
  if (root.has("T_body_camera") || out.imu) out.T_body_camera = rigid_transform(root, "T_body_camera");
  return out;
}

/// EuRoC cam0/sensor.yaml. T_BS maps sensor into body coordinates.
inline Calibration read_euroc_camera(const YamlMap& root) {
  root.allow_only({"sensor_type", "comment", "T_BS", "rate_hz", "resolution", "camera_model", "intrinsics",
                   "distortion_model", "distortion_coefficients", "readout_s"});
  Calibration out;
  CameraCalibration& camera = out.camera;
  if (root.text("camera_model") != "pinhole") root.fail("camera_model", "is not pinhole");
  camera.intrinsics = root.numbers("intrinsics");
  camera.distortion = distortion_name(root, "distortion_model");
  camera.distortion_coefficients = root.numbers("distortion_coefficients");
  set_resolution(camera, root, "resolution");
  camera.rate_hz = root.number_or("rate_hz", frame_rate_range, 0);
  check_projection(camera, root, "intrinsics", "resolution");
  check_distortion(camera, root, "distortion_coefficients");
  set_readout(camera, root);
  out.T_body_camera = rigid_transform(root, "T_BS");
  return out;
}

/// OpenCV's YAML with camera_matrix, distortion_coefficients, image_width, image_height as its calibration programs
/// write it (and as ROS camera_info does); the transform, the depth and the IMU by plumbline's names. Keys that
/// describe how the calibration was made are passed over.
inline Calibration read_opencv(const YamlMap& root) {
  root.allow_only({"image_width", "image_height", "camera_matrix", "distortion_model", "distortion_coefficients",
                   "fisheye_model", "T_body_camera", "rate_hz", "readout_s", "depth_scale", "imu",
                   // how it was made
                   "calibration_time", "camera_name", "nframes", "nr_of_frames", "board_width", "board_height",
                   "square_size", "marker_size", "aspectRatio", "fix_aspect_ratio", "flags", "flagValue",
                   "avg_reprojection_error", "per_view_reprojection_errors", "extrinsic_parameters", "image_points",
                   "grid_points", "rectification_matrix", "projection_matrix"});
  Calibration out;
  CameraCalibration& camera = out.camera;
  const std::vector<double> K = root.matrix("camera_matrix");
  if (K.size() != 9) root.fail("camera_matrix", "must have 9 values, has " + std::to_string(K.size()));
  if (K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1)
    root.fail("camera_matrix", "must be [fx 0 cx; 0 fy cy; 0 0 1]");
  camera.intrinsics = {K[0], K[4], K[2], K[5]};
  camera.width = root.positive_integer("image_width");
  camera.height = root.positive_integer("image_height");
  camera.rate_hz = root.number_or("rate_hz", frame_rate_range, 0);
  const bool fisheye = root.has("fisheye_model") && root.number("fisheye_model") != 0;
  camera.distortion = root.has("distortion_model") ? distortion_name(root, "distortion_model")
                      : fisheye                    ? "equidistant"
                                                   : "radtan";
  camera.distortion_coefficients = root.matrix("distortion_coefficients");
  if (camera.distortion == "radtan") set_rational_if_more(camera);
  check_projection(camera, root, "camera_matrix", "image_width");
  check_distortion(camera, root, "distortion_coefficients");
  set_readout(camera, root);
  out.depth_scale = root.number_or("depth_scale", depth_scale_range, 0);
  if (root.has("imu")) set_imu(out, root.map("imu"), "rate_hz");
  if (root.has("T_body_camera") || out.imu) out.T_body_camera = rigid_transform(root, "T_body_camera");
  return out;
}

}  // namespace plumbline::io::detail
