#pragma once
/// Structs with the fields of ROS messages that the node uses, in the types that ROS 2 gives them.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace message_like {

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
struct Header {
  Time stamp;
  std::string frame_id;
};
struct Vector3 {
  double x = 0, y = 0, z = 0;
};
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
struct Image {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
};
struct Imu {
  Header header;
  Vector3 angular_velocity, linear_acceleration;
};
struct CameraInfo {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
};
struct Pose {
  Vector3 position;
  Quaternion orientation;
};
struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance{};
};
struct Twist {
  Vector3 linear, angular;
};
struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};
};
struct Odometry {
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;
};
struct Transform {
  Vector3 translation;
  Quaternion rotation;
};
struct KeyValue {
  std::string key, value;
};
struct DiagnosticStatus {
  unsigned char level = 0;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
};

/// Gray, all pixels of one value.
inline Image gray_image(std::int32_t sec, std::uint32_t nanosec, std::uint32_t width, std::uint32_t height,
                        std::uint8_t value) {
  Image out;
  out.header.stamp = {sec, nanosec};
  out.width = out.step = width;
  out.height = height;
  out.encoding = "mono8";
  out.data.assign(std::size_t{width} * height, value);
  return out;
}

}  // namespace message_like
