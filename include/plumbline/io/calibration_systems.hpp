#pragma once
/// Calibrations as other systems keep them: OpenVINS (estimator_config.yaml), VINS-Mono and -Fusion, ORB-SLAM2 and -3,
/// Basalt (JSON, a part of YAML) and ROS camera_info. Keys that configure those systems are passed over.
///                                                                                     docs/guide/your_recording.md

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "plumbline/io/calibration_kalibr.hpp"

namespace plumbline::io::detail {

/// The numbers under `prefix` + each name.
inline std::vector<double> named_numbers(const YamlMap& map, const std::string& prefix,
                                         std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const char* name : names) out.push_back(map.number((prefix + name).c_str()));
  return out;
}

/// Checks what the other functions have set; `fault` is the key that is named where it is wrong.
inline void check_camera(CameraCalibration& camera, const YamlMap& map, const char* fault) {
  check_projection(camera, map, fault, fault);
  check_distortion(camera, map, fault);
}

/// The four densities and the rate, each in its range.
inline void set_noise(Calibration& out, const YamlMap& map, std::initializer_list<const char*> keys,
                      const ImuNoise& noise) {
  const Range* const ranges[] = {&gyro_density_range, &accel_density_range, &gyro_walk_range, &accel_walk_range};
  const double values[] = {noise.gyro_density, noise.accel_density, noise.gyro_walk, noise.accel_walk};
  int i = 0;
  for (const char* key : keys) {
    if (!ranges[i]->contains(values[i])) map.fail(key, "must be " + ranges[i]->text() + ", is " + text_of(values[i]));
    ++i;
  }
  out.imu = noise;
}

inline void set_vins_camera(CameraCalibration& camera, const YamlMap& map) {
  const std::string model = map.text("model_type");
  camera.width = map.positive_integer("image_width");
  camera.height = map.positive_integer("image_height");
  const YamlMap projection = map.map("projection_parameters");
  if (model == "PINHOLE") {
    camera.intrinsics = named_numbers(projection, "", {"fx", "fy", "cx", "cy"});
    camera.distortion = "radtan";
    camera.distortion_coefficients = named_numbers(map.map("distortion_parameters"), "", {"k1", "k2", "p1", "p2"});
  } else if (model == "KANNALA_BRANDT") {
    camera.intrinsics = named_numbers(projection, "", {"mu", "mv", "u0", "v0"});
    camera.distortion = "equidistant";
    camera.distortion_coefficients = named_numbers(projection, "", {"k2", "k3", "k4", "k5"});
  } else if (model == "MEI") {
    camera.model = "omni";
    camera.intrinsics = named_numbers(projection, "", {"gamma1", "gamma2", "u0", "v0"});
    camera.intrinsics.push_back(map.map("mirror_parameters").number("xi"));
    camera.distortion = "radtan";
    camera.distortion_coefficients = named_numbers(map.map("distortion_parameters"), "", {"k1", "k2", "p1", "p2"});
  } else {
    map.fail("model_type",
             "is \"" + model + "\", a model of VINS that is not read; read are PINHOLE, KANNALA_BRANDT and MEI");
  }
  check_camera(camera, map, "projection_parameters");
}

/// VINS-Mono's one file, VINS-Fusion's with cam0_calib, or the camera's file of that. Its noise is that of one sample.
inline Calibration read_vins(const YamlMap& root) {
  Calibration out;
  if (root.has("cam0_calib")) {
    const std::filesystem::path camera = root.file().parent_path() / root.text("cam0_calib");
    set_vins_camera(out.camera, YamlMap(camera));
  } else {
    set_vins_camera(out.camera, root);
  }
  if (root.has("body_T_cam0")) {
    out.T_body_camera = rigid_transform(root, "body_T_cam0");
  } else if (root.has("extrinsicRotation")) {
    const std::vector<double> R = root.matrix("extrinsicRotation"), p = root.matrix("extrinsicTranslation");
    if (R.size() != 9) root.fail("extrinsicRotation", "must have 9 values, has " + std::to_string(R.size()));
    if (p.size() != 3) root.fail("extrinsicTranslation", "must have 3 values, has " + std::to_string(p.size()));
    out.T_body_camera =
        rigid_transform(root, "extrinsicRotation",
                        {R[0], R[1], R[2], p[0], R[3], R[4], R[5], p[1], R[6], R[7], R[8], p[2], 0, 0, 0, 1});
  }
  if (root.has("td")) out.camera_time_offset_s = root.number("td", time_offset_range);
  if (root.has("rolling_shutter") && root.number("rolling_shutter") != 0)
    set_readout(out.camera, root, "rolling_shutter_tr");
  const bool has_imu = !root.has("imu") || root.number("imu") != 0;
  if (has_imu && root.has("acc_n")) {
    constexpr double rate_hz = 200;
    const double root_rate = std::sqrt(rate_hz);
    set_noise(out, root, {"gyr_n", "acc_n", "gyr_w", "acc_w"},
              {.gyro_density = root.number("gyr_n") / root_rate,
               .accel_density = root.number("acc_n") / root_rate,
               .gyro_walk = root.number("gyr_w") / root_rate,
               .accel_walk = root.number("acc_w") / root_rate,
               .rate_hz = rate_hz});
    out.notes.push_back(root.note("acc_n", "and the others are the noise of one sample in VINS: taken as " +
                                               text_of(out.imu->accel_density) +
                                               " m/s^2/sqrt(Hz) and so on, at 200 Hz"));
  }
  return out;
}

/// ORB-SLAM3 (Camera1.fx, IMU.T_b_c1) and the older files of ORB-SLAM2 and -3 (Camera.fx, Tbc).
inline Calibration read_orb_slam(const YamlMap& root) {
  Calibration out;
  CameraCalibration& camera = out.camera;
  const std::string prefix = root.has("Camera1.fx") ? "Camera1." : "Camera.";
  const std::string focal = prefix + "fx";
  const auto has = [&](const char* name) { return root.has((prefix + name).c_str()); };
  const std::string type = root.has("Camera.type") ? root.text("Camera.type") : "PinHole";
  camera.intrinsics = named_numbers(root, prefix, {"fx", "fy", "cx", "cy"});
  camera.width = root.positive_integer("Camera.width");
  camera.height = root.positive_integer("Camera.height");
  camera.rate_hz = root.number_or("Camera.fps", frame_rate_range, 0);
  if (type == "KannalaBrandt8") {
    camera.distortion = "equidistant";
    camera.distortion_coefficients = named_numbers(root, prefix, {"k1", "k2", "k3", "k4"});
  } else if (type != "PinHole" && type != "Rectified") {
    root.fail("Camera.type", "is \"" + type + "\"; known are PinHole, Rectified and KannalaBrandt8");
  } else if (type == "PinHole" && has("k1")) {
    camera.distortion = "radtan";
    camera.distortion_coefficients = named_numbers(root, prefix, {"k1", "k2", "p1", "p2"});
    if (has("k3")) camera.distortion_coefficients.push_back(root.number((prefix + "k3").c_str()));
  }
  check_camera(camera, root, focal.c_str());
  for (const char* key : {"IMU.T_b_c1", "Tbc"})
    if (root.has(key)) out.T_body_camera = rigid_transform(root, key);
  for (const char* key : {"RGBD.DepthMapFactor", "DepthMapFactor"})
    if (root.has(key)) out.depth_scale = root.number(key, depth_scale_range);
  if (root.has("IMU.NoiseGyro"))
    set_noise(out, root, {"IMU.NoiseGyro", "IMU.NoiseAcc", "IMU.GyroWalk", "IMU.AccWalk"},
              {.gyro_density = root.number("IMU.NoiseGyro"),
               .accel_density = root.number("IMU.NoiseAcc"),
               .gyro_walk = root.number("IMU.GyroWalk"),
               .accel_walk = root.number("IMU.AccWalk"),
               .rate_hz = root.number("IMU.Frequency", imu_rate_range)});
  if (root.has("Camera2.fx")) out.notes.push_back(root.note("Camera2.fx", "is not used: one camera is read, Camera1"));
  return out;
}

/// Basalt: value0 with lists of all cameras, the first of which is read; T_imu_cam is T_body_camera.
inline Calibration read_basalt(const YamlMap& root) {
  const YamlMap map = root.map("value0");
  Calibration out;
  CameraCalibration& camera = out.camera;
  const YamlMap typed = map.item("intrinsics", 0);
  const YamlMap values = typed.map("intrinsics");
  const std::string type = typed.text("camera_type");
  camera.intrinsics = named_numbers(values, "", {"fx", "fy", "cx", "cy"});
  if (type == "ds") {
    camera.model = "double_sphere";
    for (const char* name : {"xi", "alpha"}) camera.intrinsics.push_back(values.number(name));
  } else if (type == "kb4") {
    camera.distortion = "equidistant";
    camera.distortion_coefficients = named_numbers(values, "", {"k1", "k2", "k3", "k4"});
  } else if (type == "eucm" || type == "ucm") {
    camera.model = "eucm";
    camera.intrinsics.push_back(values.number("alpha"));
    camera.intrinsics.push_back(type == "eucm" ? values.number("beta") : 1);
  } else if (type == "pinhole-radtan8") {
    camera.distortion = "rational";
    camera.distortion_coefficients = named_numbers(values, "", {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"});
  } else if (type != "pinhole") {
    typed.fail("camera_type", "is \"" + type +
                                  "\", a model of Basalt that is not read; read are pinhole, pinhole-radtan8, kb4, "
                                  "ucm, eucm and ds");
  }
  const std::vector<double> size = map.numbers("resolution");
  if (size.size() < 2) map.fail("resolution", "must be [[width, height], ...]");
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
  check_projection(camera, typed, "intrinsics", "intrinsics");
  if (map.size("T_imu_cam") > 0) {
    const YamlMap pose = map.item("T_imu_cam", 0);
    const std::vector<double> q = named_numbers(pose, "", {"qw", "qx", "qy", "qz"});
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!(std::abs(rotation.norm() - 1) < 1e-3)) pose.fail("qw", "is of a quaternion that is not of unit length");
    const std::vector<double> p = named_numbers(pose, "", {"px", "py", "pz"});
    for (const double x : p)
      if (!lever_range.contains(x)) pose.fail("px", "must be " + lever_range.text() + ", has " + text_of(x));
    out.T_body_camera = SE3<double>(SO3<double>(rotation.normalized()), Vec<double, 3>(p[0], p[1], p[2]));
  }
  if (map.has("cam_time_offset_ns")) out.camera_time_offset_s = 1e-9 * map.number("cam_time_offset_ns");
  if (map.has("gyro_noise_std")) {
    const auto largest = [&](const char* key) {
      const std::vector<double> axes = map.numbers(key);
      if (axes.size() != 3) map.fail(key, "must have 3 values, has " + std::to_string(axes.size()));
      return std::max({axes[0], axes[1], axes[2]});
    };
    set_noise(out, map, {"gyro_noise_std", "accel_noise_std", "gyro_bias_std", "accel_bias_std"},
              {.gyro_density = largest("gyro_noise_std"),
               .accel_density = largest("accel_noise_std"),
               .gyro_walk = largest("gyro_bias_std"),
               .accel_walk = largest("accel_bias_std"),
               .rate_hz = map.number("imu_update_rate", imu_rate_range)});
  }
  for (const char* key : {"calib_accel_bias", "calib_gyro_bias"})
    if (map.has(key))
      for (const double value : map.numbers(key))
        if (value != 0) {
          out.notes.push_back(map.note(key, "is not applied: biases are estimated, scale and misalignment are not"));
          break;
        }
  if (map.size("intrinsics") > 1)
    out.notes.push_back(map.note("intrinsics", "has several cameras; the first one is read"));
  return out;
}

/// A message of type sensor_msgs/CameraInfo as `ros2 topic echo` or `rostopic echo` prints it.
inline Calibration read_camera_info(const YamlMap& root) {
  const bool is_ros1 = root.has("K");
  const char *k = is_ros1 ? "K" : "k", *d = is_ros1 ? "D" : "d";
  Calibration out;
  CameraCalibration& camera = out.camera;
  const std::vector<double> K = root.numbers(k);
  if (K.size() != 9) root.fail(k, "must have 9 values, has " + std::to_string(K.size()));
  camera.intrinsics = {K[0], K[4], K[2], K[5]};
  camera.width = root.positive_integer("width");
  camera.height = root.positive_integer("height");
  if (root.has(d)) camera.distortion_coefficients = root.numbers(d);
  const std::string model = root.has("distortion_model") ? root.text("distortion_model") : "";
  const bool is_zero = std::all_of(camera.distortion_coefficients.begin(), camera.distortion_coefficients.end(),
                                   [](double value) { return value == 0; });
  if (is_zero) {
    camera.distortion_coefficients.clear();
  } else if (model == "rational_polynomial") {
    camera.distortion = "radtan";
    set_rational_if_more(camera);
  } else {
    camera.distortion = distortion_name(root, "distortion_model");
  }
  check_camera(camera, root, k);
  return out;
}

/// estimator_config.yaml of OpenVINS names the files of the cameras and of the IMU.
inline Calibration read_openvins(const YamlMap& root) {
  const std::filesystem::path folder = root.file().parent_path();
  Calibration out = read_kalibr_camera(YamlMap(folder / root.text("relative_config_imucam")));
  if (root.has("relative_config_imu")) read_imu(YamlMap(folder / root.text("relative_config_imu")), out);
  return out;
}

}  // namespace plumbline::io::detail
