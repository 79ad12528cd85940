#pragma once
/// What a bag holds: the images by time and place, the IMU samples, the first calibration of each camera. One pass over
/// the bag; of images the first bytes only are read.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/bag/bag.hpp"
#include "plumbline/io/bag/image_pixels.hpp"
#include "plumbline/io/bag/messages.hpp"

namespace plumbline::io::bag {

struct IndexedImage {
  TimeNs t_ns = 0;
  Place place;
};

/// What was found of one topic.
struct IndexedTopic {
  Topic topic;
  std::optional<MessageKind> kind;  ///< empty: of no use
  std::size_t messages = 0, skipped = 0;
  std::string first_skipped;         ///< why
  std::vector<IndexedImage> images;  ///< by time, each later than the one before
  std::vector<ImuSample> imu;        ///< the same
  std::optional<CameraInfoMessage> camera_info;
  bool is_depth = false;  ///< of images: by their encoding

  bool has_images() const { return !images.empty(); }
};

namespace detail {

constexpr std::size_t largest_head = 1 << 12;  // of an image message: header, texts and sizes

inline void add_message(Bag& bag, const MessagePlace& found, IndexedTopic& out) {
  const Serialization serialization = out.topic.serialization;
  const bool is_image = out.kind == MessageKind::image || out.kind == MessageKind::compressed_image;
  if (out.kind == MessageKind::camera_info && out.camera_info) return;
  const Bytes bytes = is_image ? bag.read(found.place, largest_head) : bag.read(found.place);
  ByteReader reader(bytes, serialization);
  if (out.kind == MessageKind::image) {
    const ImageMessage image = read_image_head(reader, serialization);
    if (out.images.empty()) out.is_depth = is_depth_encoding(image.encoding);
    out.images.push_back({image.t_ns, found.place});
  } else if (out.kind == MessageKind::compressed_image) {
    const CompressedImageMessage image = read_compressed_head(reader, serialization);
    const std::string encoding = image.format.substr(0, image.format.find(';'));
    if (out.images.empty())
      out.is_depth = is_depth_encoding(encoding) || image.format.find("compressedDepth") != image.format.npos;
    out.images.push_back({image.t_ns, found.place});
  } else if (out.kind == MessageKind::imu) {
    out.imu.push_back(read_imu_message(bytes, serialization));
  } else if (out.kind == MessageKind::camera_info) {
    CameraInfoMessage info = read_camera_info_message(bytes, serialization);
    if (info.K[0] != 0) out.camera_info = std::move(info);  // 0: the camera is not calibrated
  }
}

/// In order of time, each time once: the first of those with the same.
template <class Item>
std::size_t sort_by_time(std::vector<Item>& items) {
  const std::size_t before = items.size();
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.t_ns < b.t_ns; });
  items.erase(std::unique(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.t_ns == b.t_ns; }),
              items.end());
  return before - items.size();
}

}  // namespace detail

/// Reads the whole bag. A message that cannot be read is skipped and counted.
inline std::vector<IndexedTopic> index_of(Bag& bag) {
  std::vector<IndexedTopic> out;
  while (const std::optional<MessagePlace> found = bag.next()) {
    for (std::size_t i = out.size(); i < bag.topics().size(); ++i) {
      const Topic& topic = bag.topics()[i];
      out.push_back({.topic = topic,
                     .kind = message_kind(topic.type),
                     .first_skipped = {},
                     .images = {},
                     .imu = {},
                     .camera_info = {}});
    }
    IndexedTopic& topic = out[found->topic];
    ++topic.messages;
    if (!topic.kind) continue;
    try {
      detail::add_message(bag, *found, topic);
    } catch (const std::runtime_error& error) {  // Damage, too
      if (topic.skipped++ == 0) topic.first_skipped = "message " + std::to_string(topic.messages) + " " + error.what();
    }
  }
  for (IndexedTopic& topic : out) {
    const std::size_t repeated = detail::sort_by_time(topic.images) + detail::sort_by_time(topic.imu);
    if (repeated > 0 && topic.first_skipped.empty()) topic.first_skipped = "the time stamp is that of another message";
    topic.skipped += repeated;
  }
  return out;
}

}  // namespace plumbline::io::bag
