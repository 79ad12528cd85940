#pragma once
/// What is published of an estimate: poses by REP 105, with the covariance in the order and axes of nav_msgs/Odometry.
///
///   T_odom_base = T_odom_world T_world_body T_body_base      T_map_base = T_odom_world T_map_body T_body_base
///   T_map_odom  = T_map_base T_odom_base^-1, which corrects drift, and the scale where the map estimates one
///
/// With an IMU the world has z up, and odom is the world. Without, the world has the axes of the first camera, and odom
/// those of the base at that time: T_odom_world = T_base_body.

#include <cstddef>
#include <optional>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::ros2 {

struct BaseFrame {
  SE3<double> T_odom_world, T_body_base;

  BaseFrame(const SE3<double>& T_base_body, bool has_gravity)
      : T_odom_world(has_gravity ? SE3<double>() : T_base_body), T_body_base(T_base_body.inverse()) {}

  SE3<double> T_odom_base(const SE3<double>& T_world_body) const { return T_odom_world * T_world_body * T_body_base; }
};

/// Without an IMU the body is the camera (x right, y down, z forward); the base has x forward, y left, z up (REP 103).
inline SE3<double> default_T_base_body(bool has_imu) {
  if (has_imu) return {};
  return {SO3<double>(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5)), zeros<double, 3>()};
}

/// Covariance of (x, y, z, rotation about X, Y, Z), in the axes of odom, from that of [dphi, dp] of the body: with Q
/// the rotation of the body in odom and b the base in the body
///
///   dx = Q (dp - b^ dphi),   dtheta = Q dphi
inline Mat<double, 6, 6> covariance_in_odom(const BaseFrame& base, const SE3<double>& T_world_body,
                                            const Mat<double, 6, 6>& covariance) {
  const Mat<double, 3, 3> Q = (base.T_odom_world.rotation() * T_world_body.rotation()).matrix();
  Mat<double, 6, 6> J = zeros<double, 6, 6>();
  J.topLeftCorner<3, 3>() = -Q * hat(base.T_body_base.p());
  J.topRightCorner<3, 3>() = Q;
  J.bottomLeftCorner<3, 3>() = Q;
  return J * covariance * J.transpose();
}

/// Of the base, in its own axes.
struct Twist {
  Vec<double, 3> linear = zeros<double, 3>();   ///< [m/s]
  Vec<double, 3> angular = zeros<double, 3>();  ///< [rad/s]
};

/// With an IMU: by the velocity of the body and its angular rate, bias removed.
inline Twist twist_of(const BaseFrame& base, const SE3<double>& T_world_body, const Vec<double, 3>& v_world_body,
                      const Vec<double, 3>& w_body) {
  const SO3<double> R_base_body = base.T_body_base.rotation().inverse();
  const Vec<double, 3> v_body = T_world_body.rotation().inverse() * v_world_body;
  return {R_base_body * Vec<double, 3>(v_body + w_body.cross(base.T_body_base.p())), R_base_body * w_body};
}

/// Without: the mean from one pose to the next.
inline Twist mean_twist(const SE3<double>& T_odom_before, const SE3<double>& T_odom_base, double dt_s) {
  const SE3<double> T_before_base = T_odom_before.inverse() * T_odom_base;
  const Vec<double, 3> p = T_odom_base.rotation().inverse() * Vec<double, 3>(T_odom_base.p() - T_odom_before.p());
  return {p / dt_s, T_before_base.rotation().log() / dt_s};
}

struct Odometry {
  TimeNs t_ns = 0;
  SE3<double> T_odom_base;
  Mat<double, 6, 6> covariance = zeros<double, 6, 6>();  ///< as `covariance_in_odom`
  Twist twist;
  std::optional<SE3<double>> T_map_odom;  ///< where there is a map
};

/// geometry_msgs/Vector3 and Point; geometry_msgs/Quaternion.
template <class Message>
void set_vector(const Vec<double, 3>& v, Message& message) {
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
}
template <class Message>
void set_quaternion(const SO3<double>& R, Message& message) {
  const Eigen::Quaterniond& q = R.quaternion();
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  message.w = q.w();
}

/// geometry_msgs/Pose.
template <class Message>
void set_pose(const SE3<double>& T, Message& message) {
  set_vector(T.p(), message.position);
  set_quaternion(T.rotation(), message.orientation);
}
/// geometry_msgs/Transform.
template <class Message>
void set_transform(const SE3<double>& T, Message& message) {
  set_vector(T.p(), message.translation);
  set_quaternion(T.rotation(), message.rotation);
}

/// Pose and twist of nav_msgs/Odometry. The covariance of the twist is not known, and stays as it is.
template <class Message>
void set_odometry(const Odometry& odometry, Message& message) {
  set_pose(odometry.T_odom_base, message.pose.pose);
  for (int i = 0; i < 36; ++i) message.pose.covariance[static_cast<std::size_t>(i)] = odometry.covariance(i / 6, i % 6);
  set_vector(odometry.twist.linear, message.twist.twist.linear);
  set_vector(odometry.twist.angular, message.twist.twist.angular);
}

}  // namespace plumbline::ros2
