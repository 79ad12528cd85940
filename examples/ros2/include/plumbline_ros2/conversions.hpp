#pragma once
/// Messages of sensor_msgs to the types of plumbline, and times to stamps. Templates on the messages, of which they use
/// the fields alone: no header of ROS is needed.

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>

#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/bag/image_pixels.hpp"
#include "plumbline/io/bag/messages.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace plumbline::ros2 {

constexpr TimeNs ns_of_second = 1'000'000'000;

/// builtin_interfaces/Time. Throws std::runtime_error.
template <class Stamp>
TimeNs time_of(const Stamp& stamp) {
  if (stamp.nanosec >= ns_of_second) throw std::runtime_error("has a time stamp of 1e9 nanoseconds or more");
  return TimeNs{stamp.sec} * ns_of_second + TimeNs{stamp.nanosec};
}

template <class Stamp>
void set_stamp(TimeNs t_ns, Stamp& stamp) {
  const TimeNs rest = (t_ns % ns_of_second + ns_of_second) % ns_of_second;  // nanosec has no sign
  stamp.sec = static_cast<decltype(stamp.sec)>((t_ns - rest) / ns_of_second);
  stamp.nanosec = static_cast<decltype(stamp.nanosec)>(rest);
}

/// sensor_msgs/Imu; its orientation is not used. Throws std::runtime_error where a value is not finite.
template <class Message>
ImuSample imu_sample_of(const Message& message) {
  const auto &w = message.angular_velocity, &a = message.linear_acceleration;
  if (!std::isfinite(w.x + w.y + w.z + a.x + a.y + a.z)) throw std::runtime_error("has a value that is not finite");
  return {time_of(message.header.stamp), {w.x, w.y, w.z}, {a.x, a.y, a.z}};
}

/// sensor_msgs/CameraInfo, for io::bag::calibration_of.
template <class Message>
io::bag::CameraInfoMessage camera_info_of(const Message& message) {
  return {message.width,
          message.height,
          message.distortion_model,
          {message.d.begin(), message.d.end()},
          {message.k.begin(), message.k.end()}};
}

/// An image whose pixels are those of the message, which it keeps.
struct HeldImage {
  std::shared_ptr<const void> message;
  io::bag::ImageMessage image;
};

/// sensor_msgs/Image.
template <class Message>
HeldImage held_image_of(std::shared_ptr<const Message> message) {
  io::bag::ImageMessage image;
  image.t_ns = time_of(message->header.stamp);
  image.width = message->width;
  image.height = message->height;
  image.step = message->step;
  image.encoding = message->encoding;
  image.is_bigendian = message->is_bigendian != 0;
  image.data = {message->data.data(), message->data.size()};
  return {std::move(message), std::move(image)};
}

/// 8-bit gray. Throws std::runtime_error.
inline cv::Mat gray_of(const HeldImage& held, int width, int height) {
  cv::Mat out = io::bag::pixels_of(held.image, cv::IMREAD_GRAYSCALE);
  opencv::require_resolution(out, width, height, "image");
  return out;
}

/// 16-bit depth, raw; meters as 32-bit float become raw units. Throws std::runtime_error.
inline cv::Mat depth_of(const HeldImage& held, int width, int height, double units_per_meter) {
  cv::Mat out =
      opencv::depth_of([&](int flags) { return io::bag::pixels_of(held.image, flags); }, units_per_meter, "depth");
  opencv::require_resolution(out, width, height, "depth");
  return out;
}

}  // namespace plumbline::ros2
