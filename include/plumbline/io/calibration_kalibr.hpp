#pragma once
/// Calibrations of Kalibr and of OpenVINS, which writes the same files with T_imu_cam for T_cam_imu: camchain.yaml
/// (cam0,
/// with imu0 in it or not) and imu.yaml.                                          docs/guide/your_recording.md

#include <string>
#include <vector>

#include "plumbline/io/calibration_formats.hpp"

namespace plumbline::io::detail {

/// Whether a matrix or list, rows in order, is the identity or zero, each as far as a calibration says so.
inline bool is_neutral(const std::vector<double>& values) {
  constexpr double tolerance = 1e-6;
  bool identity = values.size() == 9, zero = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    identity = identity && std::abs(values[i] - (i % 4 == 0 ? 1 : 0)) < tolerance;
    zero = zero && std::abs(values[i]) < tolerance;
  }
  return identity || zero;
}

/// Kalibr imu.yaml (bare, or under `imu0`), OpenVINS kalibr_imu_chain.yaml or EuRoC imu0/sensor.yaml.
inline void read_imu(const YamlMap& root, Calibration& out) {
  const YamlMap map = root.has("imu0") ? root.map("imu0") : root;
  map.allow_only({"gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density",
                  "accelerometer_random_walk", "gyroscope_full_scale", "accelerometer_full_scale", "rate_hz",
                  "update_rate", "rostopic", "sensor_type", "comment", "T_BS", "T_i_b", "model", "time_offset",
                  // intrinsics of the IMU: Kalibr, OpenVINS
                  "accelerometers", "gyroscopes", "Tw", "Ta", "Tg", "R_IMUtoGYRO", "R_IMUtoACC"});
  for (const char* key : {"T_BS", "T_i_b"})
    if (map.has(key) && rigid_transform(map, key).log().norm() > 1e-6)
      map.fail(key, "must be the identity: the IMU's frame is the body's");
  if (map.has("time_offset") && map.number("time_offset") != 0)
    map.fail("time_offset", "must be 0: the camera's timeshift_cam_imu is the time offset that is read");
  const char* const unapplied = "is not applied: IMU samples are expected with scale and misalignment corrected";
  for (const char* key : {"Tw", "Ta", "Tg", "R_IMUtoGYRO", "R_IMUtoACC"})
    if (map.has(key) && !is_neutral(map.matrix(key))) out.notes.push_back(map.note(key, unapplied));
  for (const char* key : {"accelerometers", "gyroscopes"})
    if (map.has(key)) out.notes.push_back(map.note(key, unapplied));
  set_imu(out, map, map.has("update_rate") ? "update_rate" : "rate_hz");
}

/// Intrinsics and distortion of one camera of a chain.
inline void set_kalibr_camera(CameraCalibration& camera, const YamlMap& map) {
  camera.intrinsics = map.numbers("intrinsics");
  const std::string model = map.text("camera_model");
  if (model == "ds") {
    camera.model = "double_sphere";
    std::vector<double>& v = camera.intrinsics;  // xi alpha fx fy cx cy -> fx fy cx cy xi alpha
    if (v.size() == 6) v = {v[2], v[3], v[4], v[5], v[0], v[1]};
  } else if (model == "omni") {
    camera.model = model;
    std::vector<double>& v = camera.intrinsics;  // xi fx fy cx cy -> fx fy cx cy xi
    if (v.size() == 5) v = {v[1], v[2], v[3], v[4], v[0]};
  } else if (model == "eucm") {
    camera.model = model;
    std::vector<double>& v = camera.intrinsics;  // alpha beta fx fy cx cy -> fx fy cx cy alpha beta
    if (v.size() == 6) v = {v[2], v[3], v[4], v[5], v[0], v[1]};
  } else if (model != "pinhole") {
    map.fail("camera_model", "is \"" + model + "\"; known are pinhole, omni, eucm and ds");
  }
  camera.distortion = distortion_name(map, "distortion_model");
  if (camera.distortion != "none") camera.distortion_coefficients = map.numbers("distortion_coeffs");
  set_resolution(camera, map, "resolution");
  check_projection(camera, map, "intrinsics", "resolution");
  check_distortion(camera, map, camera.distortion == "none" ? "distortion_model" : "distortion_coeffs");
  set_readout(camera, map, "line_delay", camera.height - 1);
  set_readout(camera, map);
}

/// The chain's cam0, and imu0 where it is in the same file. T_cam_imu maps IMU into camera coordinates, the inverse of
/// T_body_camera; T_imu_cam (OpenVINS) is T_body_camera.
inline Calibration read_kalibr_camera(const YamlMap& root) {
  const YamlMap map = root.map("cam0");
  map.allow_only({"T_cam_imu", "T_imu_cam", "T_cn_cnm1", "cam_overlaps", "camera_model", "distortion_coeffs",
                  "distortion_model", "intrinsics", "resolution", "rostopic", "timeshift_cam_imu", "line_delay",
                  "readout_s"});
  Calibration out;
  set_kalibr_camera(out.camera, map);
  if (map.has("T_imu_cam")) out.T_body_camera = rigid_transform(map, "T_imu_cam");
  if (map.has("T_cam_imu")) {
    const SE3<double> T_body_camera = rigid_transform(map, "T_cam_imu").inverse();
    if (out.T_body_camera && (out.T_body_camera->inverse() * T_body_camera).log().norm() > 1e-3)
      map.fail("T_cam_imu", "is not the inverse of T_imu_cam: leave one of them out");
    out.T_body_camera = T_body_camera;
  }
  if (map.has("timeshift_cam_imu")) out.camera_time_offset_s = map.number("timeshift_cam_imu", time_offset_range);
  if (root.has("imu0")) read_imu(root, out);
  if (root.has("cam1")) out.notes.push_back(root.note("cam1", "is not used: one camera is read, cam0"));
  return out;
}

}  // namespace plumbline::io::detail
