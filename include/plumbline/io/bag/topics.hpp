#pragma once
/// Which topics of a bag are used: those asked for, else the only one of its kind.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/bag/bag_index.hpp"
#include "plumbline/io/error.hpp"

namespace plumbline::io::bag {

/// Names of topics; empty: the only one there is, "none": do without.
struct TopicChoice {
  std::string image, depth, imu, camera_info;
};

/// What was chosen; of those that are there.
struct ChosenTopics {
  const IndexedTopic* image = nullptr;
  const IndexedTopic* depth = nullptr;
  const IndexedTopic* imu = nullptr;
  const IndexedTopic* camera_info = nullptr;
};

namespace detail {

inline std::string list_of(const std::vector<const IndexedTopic*>& topics) {
  std::string out;
  for (const IndexedTopic* topic : topics) {
    if (!out.empty()) out += ", ";
    out += topic->topic.name + " (" + std::to_string(topic->messages) + ")";
  }
  return out;
}

template <class Fits>
std::vector<const IndexedTopic*> topics_that(const std::vector<IndexedTopic>& topics, Fits&& fits) {
  std::vector<const IndexedTopic*> out;
  for (const IndexedTopic& topic : topics)
    if (fits(topic)) out.push_back(&topic);
  return out;
}

/// One of `usual`, or the one named among all that are `possible`.
inline const IndexedTopic* choose(const std::filesystem::path& bag, const std::string& name, const char* option,
                                  const std::vector<const IndexedTopic*>& possible,
                                  const std::vector<const IndexedTopic*>& usual) {
  if (name == "none") return nullptr;
  if (name.empty()) {
    if (usual.size() > 1)
      throw ReadError(bag, 0,
                      std::string("several topics (messages) fit, choose with ") + option + ": " + list_of(usual));
    return usual.empty() ? nullptr : usual.front();
  }
  for (const IndexedTopic* topic : possible)
    if (topic->topic.name == name) return topic;
  throw ReadError(bag, 0,
                  std::string(option) + " " + name + ": no such topic with messages of this kind; there are: " +
                      (possible.empty() ? "none" : list_of(possible)));
}

/// The folder of a topic; of "/cam0/image_raw/compressed" that of the image.
inline std::string camera_of(std::string name) {
  for (const std::string_view suffix : {"/compressed", "/compressedDepth"})
    if (name.ends_with(suffix)) name.resize(name.size() - suffix.size());
  const std::size_t slash = name.rfind('/');
  return slash == name.npos ? "" : name.substr(0, slash);
}

}  // namespace detail

/// All topics with their types and numbers of messages, for a message of one line.
inline std::string text_of(const std::vector<IndexedTopic>& topics) {
  std::string out;
  for (const IndexedTopic& topic : topics) {
    if (!out.empty()) out += ", ";
    out += topic.topic.name + " (" + topic.topic.type + ", " + std::to_string(topic.messages) + ")";
  }
  return out.empty() ? "none" : out;
}

/// Throws ReadError where a choice is missing or fits nothing.
inline ChosenTopics choose_topics(const std::filesystem::path& bag, const std::vector<IndexedTopic>& topics,
                                  const TopicChoice& choice) {
  using detail::choose;
  using detail::topics_that;
  ChosenTopics out;
  const auto images = topics_that(topics, [](const IndexedTopic& topic) { return topic.has_images(); });
  const auto gray = topics_that(topics, [&](const IndexedTopic& topic) {
    return topic.has_images() && !topic.is_depth && topic.topic.name != choice.depth;
  });
  out.image = choose(bag, choice.image, "--image-topic", images, gray);
  if (out.image == nullptr)
    throw ReadError(bag, 0, "has no images (sensor_msgs/Image, CompressedImage); its topics are: " + text_of(topics));
  const auto depth = topics_that(
      topics, [&](const IndexedTopic& topic) { return topic.has_images() && topic.is_depth && &topic != out.image; });
  out.depth = choose(bag, choice.depth, "--depth-topic", images, depth);
  const auto imu = topics_that(topics, [](const IndexedTopic& topic) { return !topic.imu.empty(); });
  out.imu = choose(bag, choice.imu, "--imu-topic", imu, imu);
  const auto infos = topics_that(topics, [](const IndexedTopic& topic) { return topic.camera_info.has_value(); });
  auto of_camera = topics_that(topics, [&](const IndexedTopic& topic) {
    return topic.camera_info && detail::camera_of(topic.topic.name) == detail::camera_of(out.image->topic.name);
  });
  if (of_camera.empty() && infos.size() == 1) of_camera = infos;
  if (choice.camera_info.empty() && of_camera.size() != 1) return out;  // asked for where it is needed
  out.camera_info = choose(bag, choice.camera_info, "--camera-info-topic", infos, of_camera);
  return out;
}

}  // namespace plumbline::io::bag
