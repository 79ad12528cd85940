#pragma once
/// The four calibration formats, each a function from its YAML to a `Calibration`.

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

/// plumbline's own: camera, depth, T_body_camera, imu.
inline Calibration read_plain(const YamlMap& root) {
  root.allow_only({"camera", "depth", "T_body_camera", "imu"});
  const YamlMap map = root.map("camera");
  map.allow_only({"model", "intrinsics", "distortion", "distortion_coefficients", "resolution", "rate_hz",
                  "time_offset_s", "readout_s"});
  Calibration out;
  CameraCalibration& camera = out.camera;
  camera.model = map.text("model");
  if (camera.model != "pinhole" && camera.model != "double_sphere")
    map.fail("model", "is \"" + camera.model + "\"; known are pinhole and double_sphere");
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

/// Kalibr camchain.yaml, its cam0. T_cam_imu maps IMU into camera coordinates: the inverse of T_body_camera.
inline Calibration read_kalibr_camera(const YamlMap& root) {
  const YamlMap map = root.map("cam0");
  map.allow_only({"T_cam_imu", "T_cn_cnm1", "cam_overlaps", "camera_model", "distortion_coeffs", "distortion_model",
                  "intrinsics", "resolution", "rostopic", "timeshift_cam_imu", "line_delay", "readout_s"});
  Calibration out;
  CameraCalibration& camera = out.camera;
  camera.intrinsics = map.numbers("intrinsics");
  const std::string model = map.text("camera_model");
  if (model == "ds") {
    camera.model = "double_sphere";
    std::vector<double>& v = camera.intrinsics;  // xi alpha fx fy cx cy -> fx fy cx cy xi alpha
    if (v.size() == 6) v = {v[2], v[3], v[4], v[5], v[0], v[1]};
  } else if (model != "pinhole") {
    map.fail("camera_model", "is \"" + model + "\"; known are pinhole and ds");
  }
  camera.distortion = distortion_name(map, "distortion_model");
  if (camera.distortion != "none") camera.distortion_coefficients = map.numbers("distortion_coeffs");
  set_resolution(camera, map, "resolution");
  check_projection(camera, map, "intrinsics", "resolution");
  check_distortion(camera, map, camera.distortion == "none" ? "distortion_model" : "distortion_coeffs");
  set_readout(camera, map, "line_delay", camera.height - 1);
  set_readout(camera, map);
  if (map.has("T_cam_imu")) out.T_body_camera = rigid_transform(map, "T_cam_imu").inverse();
  if (map.has("timeshift_cam_imu")) out.camera_time_offset_s = map.number("timeshift_cam_imu", time_offset_range);
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
  check_projection(camera, root, "camera_matrix", "image_width");
  check_distortion(camera, root, "distortion_coefficients");
  set_readout(camera, root);
  out.depth_scale = root.number_or("depth_scale", depth_scale_range, 0);
  if (root.has("imu")) set_imu(out, root.map("imu"), "rate_hz");
  if (root.has("T_body_camera") || out.imu) out.T_body_camera = rigid_transform(root, "T_body_camera");
  return out;
}

/// Kalibr imu.yaml (bare, or under `imu0`) or EuRoC imu0/sensor.yaml.
inline void read_imu(const YamlMap& root, Calibration& out) {
  const YamlMap map = root.has("imu0") ? root.map("imu0") : root;
  map.allow_only({"gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density",
                  "accelerometer_random_walk", "gyroscope_full_scale", "accelerometer_full_scale", "rate_hz",
                  "update_rate", "rostopic", "sensor_type", "comment", "T_BS", "T_i_b", "model", "time_offset"});
  for (const char* key : {"T_BS", "T_i_b"})
    if (map.has(key) && rigid_transform(map, key).log().norm() > 1e-6)
      map.fail(key, "must be the identity: the IMU's frame is the body's");
  set_imu(out, map, map.has("update_rate") ? "update_rate" : "rate_hz");
}

}  // namespace plumbline::io::detail
