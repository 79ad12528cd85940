#pragma once
/// Reads a calibration, its format recognized by content: plumbline's plain calibration.yaml, EuRoC sensor.yaml, Kalibr
/// camchain.yaml, OpenCV YAML, and those of OpenVINS, VINS, ORB-SLAM, OKVIS, Basalt, KITTI and ROS camera_info.
///                                                                                     docs/guide/your_recording.md
///
/// Whatever the file's convention, `T_body_camera` maps camera coordinates into body (= IMU) coordinates, and
/// `intrinsics` are in the order of CameraCalibration.

#include <filesystem>
#include <string>

#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/calibration_formats.hpp"
#include "plumbline/io/calibration_kalibr.hpp"
#include "plumbline/io/calibration_kitti.hpp"
#include "plumbline/io/calibration_names.hpp"
#include "plumbline/io/calibration_okvis.hpp"
#include "plumbline/io/calibration_systems.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io {

namespace detail {

/// By the format's own function.
inline Calibration read_recognized(const YamlMap& root) {
  const std::filesystem::path& file = root.file();
  if (root.has("camera")) return read_plain(root);
  if (root.has("cam0")) return read_kalibr_camera(root);
  if (root.has("camera_matrix")) return read_opencv(root);
  if (root.has("camera_model") || root.has("T_BS")) return read_euroc_camera(root);
  if (root.has("relative_config_imucam")) return read_openvins(root);
  if (root.has("model_type") || root.has("cam0_calib")) return read_vins(root);
  if (root.has("Camera1.fx") || root.has("Camera.fx")) return read_orb_slam(root);
  if (root.has("value0")) return read_basalt(root);
  if (root.has("width") && (root.has("k") || root.has("K"))) return read_camera_info(root);
  if (root.has("P_rect_00")) return read_kitti_raw(root);
  if (root.has("P0")) return read_kitti_odometry(root);
  if (const std::string unread = unread_format(root); !unread.empty())
    throw ReadError(file, 0, "not a camera calibration: " + unread);
  if (root.has("cameras")) return read_okvis(root);
  throw ReadError(
      file, 0,
      std::string("not a camera calibration: read are ") + read_formats + "; known and not read are " + unread_formats);
}

/// A lever arm of meters is more often one in another unit: an error beyond 20 m, a note beyond 2 m.
inline void check_lever(const std::filesystem::path& file, Calibration& calibration) {
  if (!calibration.T_body_camera) return;
  const double lever = calibration.T_body_camera->p().norm();
  constexpr double largest = 20, usual = 2;  // [m]
  if (!(lever > usual)) return;
  const std::string text = "the camera is " + text_of(lever) + " m from the IMU, by the transform between them";
  if (lever > largest)
    throw ReadError(file, 0,
                    text + "; must be at most " + text_of(largest) + " m: is it in millimeters instead of meters?");
  calibration.notes.push_back(file.string() + ": " + text + ": is it in meters?");
}

}  // namespace detail

/// Reads and checks a calibration; throws ReadError naming the file and, where there is one, the line.
inline Calibration read_calibration(const YamlMap& root) {
  Calibration out = detail::read_recognized(root);
  detail::check_lever(root.file(), out);
  return out;
}
inline Calibration read_calibration(const std::filesystem::path& file) { return read_calibration(YamlMap(file)); }

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
