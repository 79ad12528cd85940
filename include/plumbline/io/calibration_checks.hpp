#pragma once
/// What a calibration must satisfy whatever format it came in. Each error names the key and its line.

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io::detail {

// Wider than anything there is: what lies outside is a slip of unit or of the pen.
inline constexpr Range focal_range{1, 1e5, " px"};
inline constexpr Range distortion_range{-1e6, 1e6};
inline constexpr Range frame_rate_range{0.01, 1e4, " Hz"}, imu_rate_range{1, 1e5, " Hz"};
inline constexpr Range depth_scale_range{1, 1e6, " units per meter"};
inline constexpr Range time_offset_range{-3600, 3600, " s"};
inline constexpr Range lever_range{-100, 100, " m"};
inline constexpr Range gyro_density_range{1e-8, 1, " rad/s/sqrt(Hz)"}, accel_density_range{1e-7, 10, " m/s^2/sqrt(Hz)"};
inline constexpr Range gyro_walk_range{1e-10, 1, " rad/s^2/sqrt(Hz)"}, accel_walk_range{1e-9, 10, " m/s^3/sqrt(Hz)"};
inline constexpr Range gyro_full_scale_range{0.1, 1e3, " rad/s"}, accel_full_scale_range{1, 1e4, " m/s^2"};

inline std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// The rigid transform of a row-major 4x4 matrix.
inline SE3<double> rigid_transform(const YamlMap& map, const char* key, const std::vector<double>& values) {
  if (values.size() != 16) map.fail(key, "must have 16 values (4x4, row by row), has " + std::to_string(values.size()));
  const Mat<double, 4, 4> T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  if (T.row(3) != Vec<double, 4>(0, 0, 0, 1).transpose()) map.fail(key, "must have the last row 0 0 0 1");
  const Mat<double, 3, 3> R = T.topLeftCorner<3, 3>();
  const double deviation = (R.transpose() * R - Mat<double, 3, 3>::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation < 1e-3))
    map.fail(key, "has no rotation: its 3x3 block is not orthonormal (off by " + text_of(deviation) + ")");
  if (!(R.determinant() > 0)) map.fail(key, "has no rotation: its 3x3 block is a reflection (determinant -1)");
  for (int i = 0; i < 3; ++i)
    if (!lever_range.contains(T(i, 3)))
      map.fail(key, "has a translation of " + text_of(T(i, 3)) + " m; must be " + lever_range.text());
  return SE3<double>(SO3<double>::from_matrix(R), T.topRightCorner<3, 1>());
}

inline SE3<double> rigid_transform(const YamlMap& map, const char* key) {
  return rigid_transform(map, key, map.matrix(key));
}

/// One name for what the formats call differently.
inline std::string distortion_name(const YamlMap& map, const char* key) {
  const std::string name = map.text(key);
  if (name == "radtan" || name == "radial-tangential" || name == "plumb_bob" || name == "radialtangential")
    return "radtan";
  if (name == "rational" || name == "rational_polynomial" || name == "radialtangential8") return "rational";
  if (name == "equidistant" || name == "fisheye") return "equidistant";
  if (name == "fov") return "fov";
  if (name == "none") return "none";
  map.fail(key, "is \"" + name + "\"; known are none, radtan, rational, equidistant and fov");
}

/// Number of intrinsics of a model.
inline std::size_t intrinsics_of(const std::string& model) { return model == "pinhole" ? 4 : model == "omni" ? 5 : 6; }

/// The parameters of a model behind fx fy cx cy.
inline void check_shape(const CameraCalibration& camera, const YamlMap& map, const char* key) {
  const std::vector<double>& v = camera.intrinsics;
  const auto require = [&](bool holds, const std::string& what) {
    if (holds) return;
    std::string has;
    for (std::size_t i = 4; i < v.size(); ++i) has += (i > 4 ? ", " : "") + text_of(v[i]);
    map.fail(key, "must have " + what + ", has " + has);
  };
  if (camera.model == "double_sphere")
    require(v[4] > -1 && v[4] < 1 && v[5] >= 0 && v[5] <= 1, "xi in (-1, 1) and alpha in [0, 1]");
  if (camera.model == "omni") require(v[4] >= 0 && v[4] <= 10, "xi in [0, 10]");
  if (camera.model == "eucm")
    require(v[4] >= 0 && v[4] <= 1 && v[5] > 0 && v[5] <= 100, "alpha in [0, 1] and beta in (0, 100]");
}

/// The intrinsics and the resolution, as they are under `intrinsics_key` and `resolution_key`.
inline void check_projection(const CameraCalibration& camera, const YamlMap& map, const char* intrinsics_key,
                             const char* resolution_key) {
  const std::size_t expected = intrinsics_of(camera.model);
  const std::vector<double>& v = camera.intrinsics;
  if (v.size() != expected)
    map.fail(intrinsics_key, "must have " + std::to_string(expected) + " values, has " + std::to_string(v.size()));
  if (!(v[0] > 0 && v[1] > 0))
    map.fail(intrinsics_key, "has focal lengths that are not positive: " + text_of(v[0]) + ", " + text_of(v[1]));
  for (const double f : {v[0], v[1]})
    if (!focal_range.contains(f))
      map.fail(intrinsics_key, "has a focal length of " + text_of(f) + " px; must be " + focal_range.text());
  const double cx = v[2], cy = v[3];
  const auto inside = [&](int w, int h) { return cx > 0 && cx < w && cy > 0 && cy < h; };
  if (!inside(camera.width, camera.height)) {
    const bool swapped = inside(camera.height, camera.width);
    map.fail(resolution_key, std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                                 " does not contain the principal point (" + text_of(cx) + ", " + text_of(cy) + ")" +
                                 (swapped ? ": are width and height swapped?" : ""));
  }
  check_shape(camera, map, intrinsics_key);
}

/// Brings the coefficients to the number the model has; trailing zeros may be missing or superfluous.
inline void check_distortion(CameraCalibration& camera, const YamlMap& map, const char* key) {
  std::vector<double>& k = camera.distortion_coefficients;
  const auto drop_zeros_above = [&](std::size_t n) {
    while (k.size() > n && k.back() == 0) k.pop_back();
  };
  for (const double value : k)
    if (!distortion_range.contains(value))
      map.fail(key, "has a value of " + text_of(value) + "; must be " + distortion_range.text());
  const std::string has = ", has " + std::to_string(k.size());
  if (camera.distortion == "none") {
    drop_zeros_above(0);
    if (!k.empty()) map.fail(key, "must be empty or zero where the distortion is none" + has);
  } else if (camera.distortion == "radtan") {
    drop_zeros_above(5);
    if (k.size() != 4 && k.size() != 5) map.fail(key, "must have 4 or 5 values (k1 k2 p1 p2 k3)" + has);
  } else if (camera.distortion == "rational") {
    drop_zeros_above(8);
    if (k.size() != 8) map.fail(key, "must have 8 values (k1 k2 p1 p2 k3 k4 k5 k6)" + has);
  } else if (camera.distortion == "fov") {
    drop_zeros_above(1);
    if (k.size() != 1 || !(k[0] >= 0 && k[0] < 3.14)) map.fail(key, "must have 1 value (w, 0 to 3.14 rad)" + has);
  } else if (k.size() != 4) {
    map.fail(key, "must have 4 values (k1 k2 k3 k4)" + has);
  }
  const bool takes = camera.model == "pinhole" || camera.distortion == "none" ||
                     (camera.model == "omni" && camera.distortion == "radtan");
  if (!takes && camera.model == "omni") map.fail(key, "must be none or radtan: omni takes no other distortion");
  if (!takes) map.fail(key, "must be empty: " + camera.model + " has no distortion of its own");
}

inline void set_resolution(CameraCalibration& camera, const YamlMap& map, const char* key) {
  const std::vector<double> size = map.numbers(key);
  if (size.size() != 2) map.fail(key, "must be [width, height]");
  for (const double n : size)
    if (!(n > 0 && n < 1e6 && n == std::floor(n)))
      map.fail(key, "must be two positive whole numbers, has " + text_of(n));
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
}

/// The four noise densities and, where stated, the full scales; `rate_key` differs between the formats.
inline void set_imu(Calibration& out, const YamlMap& map, const char* rate_key) {
  out.imu = ImuNoise{.gyro_density = map.number("gyroscope_noise_density", gyro_density_range),
                     .accel_density = map.number("accelerometer_noise_density", accel_density_range),
                     .gyro_walk = map.number("gyroscope_random_walk", gyro_walk_range),
                     .accel_walk = map.number("accelerometer_random_walk", accel_walk_range),
                     .rate_hz = map.number(rate_key, imu_rate_range)};
  ImuBufferOptions& limits = out.imu_limits;
  limits.gyro_full_scale = map.number_or("gyroscope_full_scale", gyro_full_scale_range, limits.gyro_full_scale);
  limits.accel_full_scale = map.number_or("accelerometer_full_scale", accel_full_scale_range, limits.accel_full_scale);
}

}  // namespace plumbline::io::detail
