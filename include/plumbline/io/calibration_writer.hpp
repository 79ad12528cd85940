#pragma once
/// Writes a calibration in the format of plumbline or of Kalibr; read again, it is the same one. What the format has no
/// key for is listed.                                                              docs/guide/your_recording.md

#include <array>
#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/calibration_data.hpp"

namespace plumbline::io {

struct WrittenCalibration {
  std::string text;
  std::vector<std::string> lost;  ///< what the format cannot state
};

namespace detail {

/// The shortest text that is read as the same number.
inline std::string exact(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), error == std::errc{} ? end : text.data()};
}

inline std::string list_of(const std::vector<double>& values) {
  std::string out = "[";
  for (const double value : values) out += (out.size() > 1 ? ", " : "") + exact(value);
  return out + "]";
}

/// The rows of a 4x4 matrix, each behind `indent`.
inline std::string rows_of(const SE3<double>& T, const std::string& indent, bool are_items) {
  std::string out;
  for (int row = 0; row < 4; ++row) {
    std::vector<double> values{0, 0, 0, 1};
    for (int column = 0; column < 3 && row < 3; ++column) values[std::size_t(column)] = T.R()(row, column);
    if (row < 3) values[3] = T.p()[row];
    const std::string text = list_of(values);
    out += indent;
    if (are_items) {
      out += "- ";
      out += text;
    } else {
      out.append(text, 1, text.size() - 2);
      out += row < 3 ? "," : "]";
    }
    out += '\n';
  }
  return out;
}

inline std::string noise_of(const Calibration& calibration, const char* rate_key) {
  const ImuNoise& noise = *calibration.imu;
  std::string out;
  const auto add = [&](const char* key, double value) { out += std::string("  ") + key + ": " + exact(value) + "\n"; };
  add(rate_key, noise.rate_hz);
  add("gyroscope_noise_density", noise.gyro_density);
  add("gyroscope_random_walk", noise.gyro_walk);
  add("accelerometer_noise_density", noise.accel_density);
  add("accelerometer_random_walk", noise.accel_walk);
  const ImuBufferOptions defaults;
  const ImuBufferOptions& limits = calibration.imu_limits;
  if (limits.gyro_full_scale != defaults.gyro_full_scale) add("gyroscope_full_scale", limits.gyro_full_scale);
  if (limits.accel_full_scale != defaults.accel_full_scale) add("accelerometer_full_scale", limits.accel_full_scale);
  return out;
}

/// In single quotes, as YAML has them.
inline std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

}  // namespace detail

/// calibration.yaml of plumbline, which has a key for everything.
inline WrittenCalibration write_plain(const Calibration& calibration) {
  const CameraCalibration& camera = calibration.camera;
  std::string out =
      "camera:\n  model: " + camera.model + "\n  intrinsics: " + detail::list_of(camera.intrinsics) + "\n";
  if (camera.distortion != "none")
    out += "  distortion: " + camera.distortion +
           "\n  distortion_coefficients: " + detail::list_of(camera.distortion_coefficients) + "\n";
  out += "  resolution: [" + std::to_string(camera.width) + ", " + std::to_string(camera.height) + "]\n";
  if (camera.rate_hz > 0) out += "  rate_hz: " + detail::exact(camera.rate_hz) + "\n";
  if (camera.readout_s) out += "  readout_s: " + detail::exact(*camera.readout_s) + "\n";
  if (calibration.camera_time_offset_s != 0)
    out += "  time_offset_s: " + detail::exact(calibration.camera_time_offset_s) + "\n";
  if (calibration.mask)
    out += "  mask: " + detail::quoted(std::filesystem::absolute(*calibration.mask).string()) + "\n";
  if (calibration.depth_scale > 0) out += "depth:\n  scale: " + detail::exact(calibration.depth_scale) + "\n";
  if (calibration.T_body_camera)
    out += "T_body_camera:  # camera coordinates into those of the body (= IMU)\n  [\n" +
           detail::rows_of(*calibration.T_body_camera, "   ", false);
  if (calibration.imu) out += "imu:\n" + detail::noise_of(calibration, "rate_hz");
  return {out, {}};
}

/// camchain.yaml of Kalibr with `imu0` in it. Throws std::invalid_argument for a camera that Kalibr does not have.
inline WrittenCalibration write_kalibr(const Calibration& calibration) {
  const CameraCalibration& camera = calibration.camera;
  WrittenCalibration out;
  std::vector<double> v = camera.intrinsics, k = camera.distortion_coefficients;
  std::string model = "pinhole";
  if (camera.model == "double_sphere" || camera.model == "eucm") {
    model = camera.model == "eucm" ? "eucm" : "ds";
    v = {v.at(4), v.at(5), v[0], v[1], v[2], v[3]};
  } else if (camera.model == "omni") {
    model = "omni";
    v = {v.at(4), v[0], v[1], v[2], v[3]};
  }
  if (camera.distortion == "radtan" && k.size() == 5 && k[4] == 0) k.pop_back();
  if (camera.distortion == "rational" || (camera.distortion == "radtan" && k.size() > 4))
    throw std::invalid_argument("Kalibr has no distortion with k3 beside p1 and p2: it can be written --to plain");
  out.text = "cam0:\n";
  if (calibration.T_body_camera)
    out.text += "  T_cam_imu:  # IMU coordinates into those of the camera\n" +
                detail::rows_of(calibration.T_body_camera->inverse(), "  ", true);
  out.text += "  camera_model: " + model + "\n  intrinsics: " + detail::list_of(v) +
              "\n  distortion_model: " + camera.distortion + "\n  distortion_coeffs: " + detail::list_of(k) +
              "\n  resolution: [" + std::to_string(camera.width) + ", " + std::to_string(camera.height) + "]\n";
  if (calibration.T_body_camera)
    out.text += "  timeshift_cam_imu: " + detail::exact(calibration.camera_time_offset_s) + "\n";
  else if (calibration.camera_time_offset_s != 0)
    out.lost.emplace_back("the time offset (there is no transform to an IMU)");
  if (camera.readout_s && camera.height > 1)
    out.text += "  line_delay: " + detail::exact(*camera.readout_s / (camera.height - 1)) + "\n";
  if (camera.rate_hz > 0) out.lost.emplace_back("the rate of the images");
  if (calibration.depth_scale > 0)
    out.lost.push_back("the depth scale (give it with --depth-scale " + detail::exact(calibration.depth_scale) + ")");
  if (calibration.mask) out.lost.push_back("the mask (give it with --mask " + calibration.mask->string() + ")");
  if (calibration.imu) out.text += "imu0:\n" + detail::noise_of(calibration, "update_rate");
  return out;
}

/// Formats of `write_calibration`.
inline constexpr std::array<std::string_view, 2> written_formats{"kalibr", "plain"};

/// `format` is one of `written_formats`.
inline WrittenCalibration write_calibration(const Calibration& calibration, std::string_view format) {
  return format == "kalibr" ? write_kalibr(calibration) : write_plain(calibration);
}

}  // namespace plumbline::io
