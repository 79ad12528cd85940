#pragma once
/// A bag, recognized by its first bytes: ROS 1 (.bag), MCAP, SQLite (.db3), or a folder of ROS 2 with one or more of
/// the last two. Read as far as it goes: where it is damaged or cut off, the notes name the byte.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/bag/bag_reader.hpp"
#include "plumbline/io/bag/mcap_file.hpp"
#include "plumbline/io/bag/ros1_bag.hpp"
#include "plumbline/io/bag/sqlite_bag.hpp"
#include "plumbline/io/error.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io::bag {

namespace detail {

using Path = std::filesystem::path;

inline std::unique_ptr<BagReader> open_file(const Path& file) {
  if (!std::filesystem::exists(file)) throw ReadError(file, 0, "no such file");
  if (!std::filesystem::is_regular_file(file)) throw ReadError(file, 0, "not a regular file");
  std::array<char, 16> bytes{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ReadError(file, 0, "cannot be opened");
  stream.read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), static_cast<std::size_t>(stream.gcount()));
  if (head.empty()) throw ReadError(file, 0, "the file is empty");
  if (head.starts_with(ros1_magic)) return std::make_unique<Ros1Bag>(file);
  if (head.starts_with(mcap_magic)) return std::make_unique<McapFile>(file);
  if (head.starts_with(sqlite_magic)) return std::make_unique<SqliteBag>(file);
  if (head.starts_with("#ROSBAG V"))
    throw ReadError(file, 0, "a bag of ROS 1 of another version than 2.0, which is not read (rosbag fix converts it)");
  if (head.starts_with("\x28\xB5\x2F\xFD"))
    throw ReadError(file, 0, "compressed as a whole, which is not read: decompress it by zstd -d");
  throw ReadError(file, 0, "not a bag: neither ROS 1 (#ROSBAG V2.0) nor MCAP nor SQLite");
}

/// What metadata.yaml names, else all that have the extension of a bag, in the order of their names.
inline std::vector<Path> files_of(const Path& folder) {
  std::vector<Path> files;
  const Path metadata = folder / "metadata.yaml";
  if (std::filesystem::exists(metadata)) {
    const YamlMap root(metadata);
    if (root.has("rosbag2_bagfile_information")) {
      const YamlMap map = root.map("rosbag2_bagfile_information");
      if (map.has("relative_file_paths"))
        for (const std::string& name : map.texts("relative_file_paths"))
          files.push_back(folder / Path(name).filename());
    }
  }
  if (!files.empty()) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".db3" || entry.path().extension() == ".mcap") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty()) throw ReadError(folder, 0, "has neither .mcap nor .db3 files");
  return files;
}

}  // namespace detail

/// A file that is no folder of a recording, or a folder of ROS 2.
inline bool is_bag(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  if (fs::is_regular_file(path)) return true;
  if (!fs::is_directory(path)) return false;
  for (const char* name : {"mav0", "rgb.txt", "times.txt", "image_0"})
    if (fs::exists(path / name)) return false;
  if (fs::exists(path / "metadata.yaml")) return true;
  for (const auto& entry : fs::directory_iterator(path))
    if (entry.path().extension() == ".db3" || entry.path().extension() == ".mcap") return true;
  return false;
}

class Bag {
 public:
  /// Throws ReadError.
  explicit Bag(const std::filesystem::path& path)
      : files_(std::filesystem::is_directory(path) ? detail::files_of(path)
                                                   : std::vector<std::filesystem::path>{path}) {
    for (const std::filesystem::path& file : files_) readers_.push_back(detail::open_file(file));
    indices_.resize(readers_.size());
  }

  const std::vector<std::filesystem::path>& files() const { return files_; }
  const std::vector<Topic>& topics() const { return topics_; }
  /// Of each file where it is damaged or odd, one line.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Every message of one file after the other; none at the end.
  std::optional<MessagePlace> next() {
    for (; file_ < readers_.size(); ++file_) {
      BagReader& reader = *readers_[file_];
      try {
        if (std::optional<MessagePlace> found = reader.next()) {
          found->topic = index_of(reader.topics(), found->topic);
          found->place.file = static_cast<std::uint32_t>(file_);
          return found;
        }
      } catch (const Damage& damage) {
        note_damage(damage);
      }
      if (const std::string remark = reader.remark(); !remark.empty())
        notes_.push_back(files_[file_].string() + ": " + remark);
      reader.release();
    }
    return std::nullopt;
  }

  /// The bytes of a message, valid until the next call of any function. Throws Damage.
  Bytes read(const Place& place, std::size_t at_most = std::numeric_limits<std::size_t>::max()) {
    if (place.file != last_read_) readers_[last_read_]->release();
    last_read_ = place.file;
    return readers_[place.file]->read(place, at_most);
  }

 private:
  void note_damage(const Damage& damage) {
    const std::string size = std::to_string(std::filesystem::file_size(files_[file_]));
    const std::string place = damage.offset_bytes() == Damage::no_offset
                                  ? "the bag is damaged and read up to there"
                                  : "the bag is damaged at byte " + std::to_string(damage.offset_bytes()) + " of " +
                                        size + " and read up to there";
    notes_.push_back(files_[file_].string() + ": " + place + ": " + damage.what());
  }

  /// Of all files, of a topic of this file.
  std::size_t index_of(const std::vector<Topic>& topics, std::size_t topic) {
    std::vector<std::size_t>& indices = indices_[file_];
    for (std::size_t i = indices.size(); i < topics.size(); ++i) {
      const auto same = std::find_if(topics_.begin(), topics_.end(), [&](const Topic& each) {
        return each.name == topics[i].name && each.type == topics[i].type &&
               each.serialization == topics[i].serialization;
      });
      indices.push_back(static_cast<std::size_t>(same - topics_.begin()));
      if (same == topics_.end()) topics_.push_back(topics[i]);
    }
    return indices[topic];
  }

  std::vector<std::filesystem::path> files_;
  std::vector<std::unique_ptr<BagReader>> readers_;
  std::vector<std::vector<std::size_t>> indices_;  // of the topics of each file among those of all
  std::vector<Topic> topics_;
  std::vector<std::string> notes_;
  std::size_t file_ = 0, last_read_ = 0;
};

}  // namespace plumbline::io::bag
