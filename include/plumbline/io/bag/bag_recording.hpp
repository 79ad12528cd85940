#pragma once
/// A bag as a recording: frames and IMU samples by the time stamps of their headers, the calibration by CameraInfo or a
/// file beside the bag.                                                                         docs/guide/bags.md

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "plumbline/io/bag/bag.hpp"
#include "plumbline/io/bag/bag_index.hpp"
#include "plumbline/io/bag/camera_info.hpp"
#include "plumbline/io/bag/topics.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/recording.hpp"

namespace plumbline::io::bag {

/// An image as a file would have it.
struct EncodedImage {
  std::vector<std::uint8_t> bytes;  ///< of the JPEG or PNG that was sent; empty: `pixels`
  cv::Mat pixels;
};

/// The images of the chosen topics, numbered; those of depth after the others.
class BagImages final : public ImageSource {
  struct Images {
    Topic topic;
    MessageKind kind;
    std::vector<IndexedImage> images;
  };

  template <class Use>
  auto use(std::size_t image, Use&& use) {
    const bool is_second = image >= topics_.front().images.size();
    const Images& of = topics_.at(is_second ? 1 : 0);
    const IndexedImage& indexed = of.images.at(is_second ? image - topics_.front().images.size() : image);
    const std::string name = bag_->files()[indexed.place.file].string() + ": " + of.topic.name + " at " +
                             std::to_string(indexed.t_ns) + " ns";
    const auto named = [&](const std::runtime_error& error) {
      const std::string what = error.what();
      return std::runtime_error(what.starts_with(name) ? what : name + ": " + what);
    };
    try {
      const Bytes bytes = bag_->read(indexed.place);
      if (of.kind == MessageKind::image) {
        const ImageMessage message = read_image_message(bytes, of.topic.serialization);
        return use(nullptr, &message, name);
      }
      const CompressedImageMessage message = read_compressed_message(bytes, of.topic.serialization);
      return use(&message, nullptr, name);
    } catch (const std::runtime_error& error) {
      throw named(error);
    }
  }

 public:
  BagImages(std::shared_ptr<Bag> bag, const ChosenTopics& chosen) : bag_(std::move(bag)) {
    for (const IndexedTopic* topic : {chosen.image, chosen.depth})
      if (topic != nullptr) topics_.push_back({topic->topic, *topic->kind, topic->images});
  }

  cv::Mat read(std::size_t image, int flags) override {
    return use(image, [&](const CompressedImageMessage* file, const ImageMessage* pixels, const std::string& name) {
      return file != nullptr ? opencv::decode_image(file_in(*file), flags, name) : pixels_of(*pixels, flags);
    });
  }
  EncodedImage encoded(std::size_t image) {
    return use(image, [&](const CompressedImageMessage* file, const ImageMessage* pixels, const std::string&) {
      if (file == nullptr) return EncodedImage{{}, pixels_of(*pixels, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR)};
      const Bytes bytes = file_in(*file);
      return EncodedImage{{bytes.begin(), bytes.end()}, {}};
    });
  }

 private:
  std::shared_ptr<Bag> bag_;
  std::vector<Images> topics_;
};

namespace detail {

/// NAME.FILE beside a bag called NAME.bag, else FILE in the folder of the bag.
inline std::optional<Path> beside(const Path& bag, const std::string& file) {
  if (std::filesystem::is_directory(bag)) return io::detail::if_exists(bag / file);
  const Path folder = bag.parent_path();
  if (const auto own = io::detail::if_exists(folder / (bag.stem().string() + "." + file))) return own;
  return io::detail::if_exists(folder / file);
}

/// Says so; more than half of the messages skipped are an error.
inline void note_skipped(const Path& name, const IndexedTopic& topic, std::vector<std::string>& notes) {
  if (topic.skipped == 0) return;
  const std::string text = std::to_string(topic.skipped) + " of " + std::to_string(topic.messages) +
                           " messages are skipped (first: " + topic.first_skipped + ")";
  if (2 * topic.skipped > topic.messages) throw ReadError(name, 0, text);
  notes.push_back(name.string() + ": " + text);
}

}  // namespace detail

/// Opens a bag and reads all of it once; throws ReadError.
inline Recording open_recording(const std::filesystem::path& path, const TopicChoice& choice,
                                const Recording::Options& options) {
  const auto bag = std::make_shared<Bag>(path);
  const std::vector<IndexedTopic> topics = index_of(*bag);
  RecordingFiles files;
  files.notes = bag->notes();
  if (topics.empty() && !files.notes.empty()) throw ReadError(path, 0, "has no messages; " + files.notes.front());
  const ChosenTopics chosen = choose_topics(path, topics, choice);
  const auto name_of = [&](const IndexedTopic& topic) { return detail::Path(path.string() + " " + topic.topic.name); };
  files.layout = Layout::bag;
  files.root = path;
  files.bag = bag->files();
  files.frame_index = name_of(*chosen.image);

  std::string used;
  for (const IndexedTopic* topic : {chosen.image, chosen.depth, chosen.imu, chosen.camera_info}) {
    if (topic == nullptr) continue;
    used += (used.empty() ? "" : ", ") + topic->topic.name + " (" + std::to_string(topic->messages) + ")";
    detail::note_skipped(name_of(*topic), *topic, files.notes);
  }
  files.notes.push_back(path.string() + ": topics (messages) used: " + used);

  const auto images = std::make_shared<BagImages>(bag, chosen);
  std::size_t number = 0;
  const auto frames_of = [&](const IndexedTopic& topic) {
    std::vector<FrameSample> frames;
    for (const IndexedImage& image : topic.images)
      frames.push_back({.t_ns = image.t_ns,
                        .image = name_of(topic).string() + " at " + std::to_string(image.t_ns) + " ns",
                        .depth = {},
                        .source = images,
                        .image_number = number++});
    return frames;
  };
  files.frames = frames_of(*chosen.image);
  if (chosen.depth != nullptr) {
    files.depth_index = name_of(*chosen.depth);
    files.has_depth = true;
    io::detail::associate_depth(files.frames, frames_of(*chosen.depth));
  }
  if (chosen.imu != nullptr) {
    files.imu_index = name_of(*chosen.imu);
    files.imu = chosen.imu->imu;
    files.held_accel = io::detail::note_held(*files.imu_index, files.imu, files.notes);
  }
  files.camera_truth = detail::beside(path, "groundtruth.txt");
  files.body_truth = detail::beside(path, "groundtruth_body.csv");

  std::optional<Calibration> own;
  files.calibration = path;
  if (const auto file = detail::beside(path, "calibration.yaml")) {
    files.calibration = *file;
  } else if (chosen.camera_info != nullptr) {
    files.calibration = name_of(*chosen.camera_info);
    if (!options.calibration) own = calibration_of(files.calibration, *chosen.camera_info->camera_info);
    if (own && chosen.depth != nullptr) own->depth_scale = 1000;  // REP 118: millimeters, or meters as float
  } else if (!options.calibration) {
    throw ReadError(
        path, 0,
        "has no calibration for " + chosen.image->topic.name +
            ": choose one of its CameraInfo with --camera-info-topic, or give --calibration; its topics are: " +
            text_of(topics));
  }
  return Recording::open(std::move(files), own, options);
}

}  // namespace plumbline::io::bag
