#pragma once
/// The messages of sensor_msgs that are read: Image, CompressedImage, Imu, CameraInfo. Bytes are not copied.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/bag/byte_reader.hpp"

namespace plumbline::io::bag {

enum class MessageKind : std::uint8_t { image, compressed_image, imu, camera_info };

/// Of a type's name in ROS 1 or ROS 2; none of all others.
inline std::optional<MessageKind> message_kind(std::string_view type) {
  for (const std::string_view folder : {"sensor_msgs/msg/", "sensor_msgs/"}) {
    if (!type.starts_with(folder)) continue;
    const std::string_view name = type.substr(folder.size());
    if (name == "Image") return MessageKind::image;
    if (name == "CompressedImage") return MessageKind::compressed_image;
    if (name == "Imu") return MessageKind::imu;
    if (name == "CameraInfo") return MessageKind::camera_info;
  }
  return std::nullopt;
}

/// The time stamp of a message's header; the reader stands after the header then.
inline TimeNs read_stamp(ByteReader& reader, Serialization serialization) {
  if (serialization == Serialization::ros1) reader.number<std::uint32_t>();  // a counter
  const std::int64_t seconds = serialization == Serialization::ros1 ? std::int64_t{reader.number<std::uint32_t>()}
                                                                    : std::int64_t{reader.number<std::int32_t>()};
  const std::int64_t nanoseconds = reader.number<std::uint32_t>();
  if (nanoseconds >= 1'000'000'000) throw std::runtime_error("has a time stamp of 1e9 nanoseconds or more");
  reader.text();  // frame_id
  return seconds * 1'000'000'000 + nanoseconds;
}

inline ImuSample read_imu_message(Bytes bytes, Serialization serialization) {
  ByteReader reader(bytes, serialization);
  ImuSample out;
  out.t_ns = read_stamp(reader, serialization);
  constexpr std::size_t orientation = 4, covariance = 9;
  reader.numbers(orientation + covariance);
  const std::vector<double> gyro = reader.numbers(3);
  reader.numbers(covariance);
  const std::vector<double> accel = reader.numbers(3);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!std::isfinite(gyro[k]) || !std::isfinite(accel[k])) throw std::runtime_error("has a value that is not finite");
    out.gyro[i] = gyro[k];
    out.accel[i] = accel[k];
  }
  return out;
}

/// Pixels as they were sent, row by row.
struct ImageMessage {
  TimeNs t_ns = 0;
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;
  bool is_bigendian = false;
  Bytes data;
};

/// All of an image but its pixels: stops before them, so that the first bytes of a message are enough.
inline ImageMessage read_image_head(ByteReader& reader, Serialization serialization) {
  ImageMessage out;
  out.t_ns = read_stamp(reader, serialization);
  out.height = reader.number<std::uint32_t>();
  out.width = reader.number<std::uint32_t>();
  out.encoding = reader.text();
  out.is_bigendian = reader.number<std::uint8_t>() != 0;
  out.step = reader.number<std::uint32_t>();
  return out;
}

inline ImageMessage read_image_message(Bytes bytes, Serialization serialization) {
  ByteReader reader(bytes, serialization);
  ImageMessage out = read_image_head(reader, serialization);
  out.data = reader.sequence();
  return out;
}

/// An image as a JPEG or PNG.
struct CompressedImageMessage {
  TimeNs t_ns = 0;
  std::string format;
  Bytes data;
};

inline CompressedImageMessage read_compressed_head(ByteReader& reader, Serialization serialization) {
  CompressedImageMessage out;
  out.t_ns = read_stamp(reader, serialization);
  out.format = reader.text();
  return out;
}

inline CompressedImageMessage read_compressed_message(Bytes bytes, Serialization serialization) {
  ByteReader reader(bytes, serialization);
  CompressedImageMessage out = read_compressed_head(reader, serialization);
  out.data = reader.sequence();
  return out;
}

struct CameraInfoMessage {
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> D, K;
};

inline CameraInfoMessage read_camera_info_message(Bytes bytes, Serialization serialization) {
  ByteReader reader(bytes, serialization);
  CameraInfoMessage out;
  read_stamp(reader, serialization);
  out.height = reader.number<std::uint32_t>();
  out.width = reader.number<std::uint32_t>();
  out.distortion_model = reader.text();
  out.D = reader.numbers(reader.number<std::uint32_t>());
  out.K = reader.numbers(9);
  return out;
}

}  // namespace plumbline::io::bag
