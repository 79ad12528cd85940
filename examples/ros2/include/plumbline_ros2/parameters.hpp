#pragma once
/// The parameters of the node by name, with their checks. A name that is not among them is refused: the default of a
/// misspelled parameter is never used without a word.

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/nearest.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline_ros2/odometry.hpp"

namespace plumbline::ros2 {

struct Parameters {
  std::string config, calibration, imu_calibration, mask;
  double depth_scale = 0, depth_tolerance_s = 0.02;
  std::int64_t queue = 4, path_length = 0;
  bool map = false, all_poses = false, publish_tf = true;
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  std::vector<double> T_base_body;
};

/// Calls `visit(name, value, description)` for each.
template <class Values, class Visit>
void for_each_parameter(Values& p, Visit&& visit) {
  visit("config", p.config, "configuration, of those that are built; empty: the first one");
  visit("calibration", p.calibration, "file; empty: camera_info, for a configuration without an IMU");
  visit("imu_calibration", p.imu_calibration, "file with the noise of the IMU; empty: that of the calibration");
  visit("mask", p.mask, "gray image whose zero pixels are not used; empty: that of the calibration");
  visit("depth_scale", p.depth_scale, "raw units of depth per meter; 0: that of the calibration, else 1000 (REP 118)");
  visit("depth_tolerance_s", p.depth_tolerance_s, "between the time stamps of an image and its depth [s]");
  visit("queue", p.queue, "frames that wait; where they are more, the oldest one is dropped");
  visit("map", p.map, "close loops, and publish map -> odom");
  visit("all_poses", p.all_poses, "publish poses of uncertain scale and held ones as well");
  visit("publish_tf", p.publish_tf, "publish transforms");
  visit("path_length", p.path_length, "poses of the path; 0: none is published");
  visit("map_frame", p.map_frame, "REP 105");
  visit("odom_frame", p.odom_frame, "REP 105");
  visit("base_frame", p.base_frame, "REP 105");
  visit("T_base_body", p.T_base_body, "body (the IMU, else the camera) in the base frame: x y z qx qy qz qw");
}

inline std::vector<std::string> parameter_names() {
  std::vector<std::string> out;
  const Parameters defaults;
  for_each_parameter(defaults, [&](const char* name, const auto&, const char*) { out.emplace_back(name); });
  return out;
}

/// Throws std::invalid_argument for a name that is neither of the node nor of ROS.
inline void require_known(const std::string& given) {
  const std::string_view name = given;
  if (name == "use_sim_time" || name == "start_type_description_service" || name.starts_with("qos_overrides.")) return;
  const std::vector<std::string> known = parameter_names();
  for (const std::string& each : known)
    if (each == given) return;
  throw std::invalid_argument("parameter \"" + given + "\" is unknown, " + io::suggestion(given, known));
}

/// Throws std::invalid_argument.
inline void check(const Parameters& p) {
  const auto require = [](bool is_so, const std::string& what) {
    if (!is_so) throw std::invalid_argument("parameter " + what);
  };
  require(p.depth_scale >= 0 && std::isfinite(p.depth_scale), "depth_scale must be positive, or 0");
  require(p.depth_tolerance_s >= 0 && p.depth_tolerance_s <= 1, "depth_tolerance_s must be from 0 to 1");
  require(p.queue >= 1 && p.queue <= 1000, "queue must be from 1 to 1000");
  require(p.path_length >= 0 && p.path_length <= 1'000'000, "path_length must be from 0 to 1000000");
  const auto is_frame = [](const std::string& name) { return !name.empty() && name.front() != '/'; };
  require(is_frame(p.odom_frame) && is_frame(p.base_frame) && is_frame(p.map_frame),
          "map_frame, odom_frame and base_frame must be names without a leading slash");
  require(p.odom_frame != p.base_frame && p.odom_frame != p.map_frame && p.base_frame != p.map_frame,
          "map_frame, odom_frame and base_frame must differ");
  require(p.T_base_body.empty() || p.T_base_body.size() == 7, "T_base_body must have 7 values: x y z qx qy qz qw");
  double sum = 0;
  for (const double value : p.T_base_body) sum += value;
  require(std::isfinite(sum), "T_base_body must be finite");
  if (p.T_base_body.empty()) return;
  const std::vector<double>& v = p.T_base_body;
  const double norm = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  require(std::abs(norm - 1) < 1e-3, "T_base_body must have a quaternion (x y z w) of unit length");
}

inline SE3<double> T_base_body_of(const Parameters& p, bool has_imu) {
  const std::vector<double>& v = p.T_base_body;
  if (v.empty()) return default_T_base_body(has_imu);
  return {SO3<double>(Eigen::Quaterniond(v[6], v[3], v[4], v[5])), Vec<double, 3>(v[0], v[1], v[2])};
}

}  // namespace plumbline::ros2
