#pragma once
/// Configurations of OKVIS and OKVIS2: the list `cameras`, of which the first one is read, and imu_parameters (OKVIS:
/// imu_params). T_SC maps camera into IMU coordinates.                            docs/guide/your_recording.md

#include <string>
#include <vector>

#include "plumbline/io/calibration_systems.hpp"

namespace plumbline::io::detail {

/// Noise, full scales and rate; 200 Hz where no rate is stated.
inline void set_okvis_imu(Calibration& out, const YamlMap& map) {
  set_noise(out, map, {"sigma_g_c", "sigma_a_c", "sigma_gw_c", "sigma_aw_c"},
            {.gyro_density = map.number("sigma_g_c"),
             .accel_density = map.number("sigma_a_c"),
             .gyro_walk = map.number("sigma_gw_c"),
             .accel_walk = map.number("sigma_aw_c"),
             .rate_hz = map.number_or("imu_rate", imu_rate_range, 200)});
  ImuBufferOptions& limits = out.imu_limits;
  limits.gyro_full_scale = map.number_or("g_max", gyro_full_scale_range, limits.gyro_full_scale);
  limits.accel_full_scale = map.number_or("a_max", accel_full_scale_range, limits.accel_full_scale);
  if (map.has("T_BS") && rigid_transform(map, "T_BS").log().norm() > 1e-6)
    out.notes.push_back(map.note("T_BS", "is not used: the body is the IMU"));
}

inline Calibration read_okvis(const YamlMap& root) {
  const YamlMap map = root.item("cameras", 0);
  Calibration out;
  CameraCalibration& camera = out.camera;
  const std::vector<double> focal = map.numbers("focal_length"), center = map.numbers("principal_point");
  if (focal.size() != 2) map.fail("focal_length", "must have 2 values, has " + std::to_string(focal.size()));
  if (center.size() != 2) map.fail("principal_point", "must have 2 values, has " + std::to_string(center.size()));
  camera.intrinsics = {focal[0], focal[1], center[0], center[1]};
  camera.distortion = distortion_name(map, "distortion_type");
  if (camera.distortion != "none") camera.distortion_coefficients = map.numbers("distortion_coefficients");
  set_resolution(camera, map, "image_dimension");
  check_projection(camera, map, "focal_length", "image_dimension");
  check_distortion(camera, map, camera.distortion == "none" ? "distortion_type" : "distortion_coefficients");
  out.T_body_camera = rigid_transform(map, "T_SC");
  if (root.has("camera_parameters")) {
    const YamlMap all = root.map("camera_parameters");
    if (all.has("image_delay"))  // correct time stamp = time stamp - delay
      out.camera_time_offset_s = 0 - all.number("image_delay", time_offset_range);
  }
  for (const char* key : {"imu_parameters", "imu_params"})
    if (root.has(key)) set_okvis_imu(out, root.map(key));
  if (root.size("cameras") > 1) out.notes.push_back(root.note("cameras", "has several; the first one is read"));
  return out;
}

}  // namespace plumbline::io::detail
