#pragma once
/// Reads a calibration from any of four formats, recognized by content: plumbline's plain calibration.yaml, EuRoC
/// sensor.yaml, Kalibr camchain.yaml, OpenCV YAML.                                docs/guide/your_recording.md
///
/// Whatever the file's convention, `T_body_camera` maps camera coordinates into body (= IMU) coordinates, and
/// `intrinsics` are fx fy cx cy [px], for double_sphere followed by xi alpha.

#include <filesystem>

#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/calibration_formats.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io {

/// Reads and checks a calibration; throws ReadError naming the file and, where there is one, the line.
inline Calibration read_calibration(const std::filesystem::path& file) {
  const YamlMap root(file);
  if (root.has("camera")) return detail::read_plain(root);
  if (root.has("cam0")) return detail::read_kalibr_camera(root);
  if (root.has("camera_matrix")) return detail::read_opencv(root);
  if (root.has("camera_model") || root.has("T_BS")) return detail::read_euroc_camera(root);
  throw ReadError(
      file, 0,
      "not a camera calibration: expected the key camera (plumbline), cam0 (Kalibr), camera_matrix (OpenCV) "
      "or camera_model (EuRoC)");
}

/// The same with the IMU from a file of its own (Kalibr imu.yaml, EuRoC imu0/sensor.yaml); the camera's file must then
/// give the transform between the two.
inline Calibration read_calibration(const std::filesystem::path& camera_file, const std::filesystem::path& imu_file) {
  Calibration out = read_calibration(camera_file);
  detail::read_imu(YamlMap(imu_file), out);
  if (!out.T_body_camera)
    throw ReadError(camera_file, 0, "no transform between camera and IMU (T_body_camera, T_cam_imu or T_BS)");
  return out;
}

}  // namespace plumbline::io
