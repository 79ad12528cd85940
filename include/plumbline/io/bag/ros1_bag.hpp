#pragma once
/// Bags of ROS 1, version 2.0: records of a header (fields name=value) and data; chunks hold the connections and
/// messages. The index at the end is not needed and not read, so that a bag that was never closed is read as well.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/bag/bag_reader.hpp"
#include "plumbline/io/bag/chunk_store.hpp"

namespace plumbline::io::bag {

inline constexpr std::string_view ros1_magic = "#ROSBAG V2.0\n";

class Ros1Bag final : public BagReader {
 public:
  explicit Ros1Bag(const std::filesystem::path& path) : file_(path), chunks_(file_) {}

  std::optional<MessagePlace> next() override {
    for (;;) {
      if (container_ != Place::no_container) {
        if (const auto found = next_in_chunk()) return found;
        container_ = Place::no_container;
        if (at_ > file_.size()) throw Damage(file_.size(), "the file ends in a chunk");
        continue;
      }
      if (at_ == file_.size()) return std::nullopt;
      if (const auto found = next_in_file()) return found;
    }
  }
  Bytes read(const Place& place, std::size_t at_most) override { return chunks_.read(place, at_most); }
  void release() override { chunks_.release(); }
  std::string remark() const override { return was_closed_ ? "" : "the bag was not closed when it was recorded"; }

 private:
  enum Kind : int { message = 2, bag_header = 3, chunk = 5, connection = 7 };  // others are of the index

  struct Fields {
    int kind = -1;
    std::uint32_t connection = 0, size = 0;
    std::uint64_t index_offset = 0;
    std::string topic, type, compression;
  };

  /// Of a header, or of the data of a connection.
  static Fields read_fields(Bytes bytes, std::uint64_t offset) {
    Fields out;
    try {
      for (ByteReader reader(bytes); reader.left() > 0;) {
        const Bytes field = reader.sequence();
        const std::string_view text(reinterpret_cast<const char*>(field.data()), field.size());
        const std::size_t equals = text.find('=');
        if (equals == text.npos) throw Damage(offset, "a field of a header has no value");
        const std::string_view name = text.substr(0, equals), value = text.substr(equals + 1);
        ByteReader number(field.subspan(equals + 1));
        if (name == "op") out.kind = number.number<std::uint8_t>();
        if (name == "conn") out.connection = number.number<std::uint32_t>();
        if (name == "size") out.size = number.number<std::uint32_t>();
        if (name == "index_pos") out.index_offset = number.number<std::uint64_t>();
        if (name == "topic") out.topic = value;
        if (name == "type") out.type = value;
        if (name == "compression") out.compression = value;
      }
    } catch (const Damage&) {
      throw;
    } catch (const std::runtime_error&) {
      throw Damage(offset, "the header of a record is damaged");
    }
    return out;
  }

  /// The record at `at_`: takes it in, or gives the message that it is.
  std::optional<MessagePlace> next_in_file() {
    const std::uint64_t begin = at_;
    const std::uint32_t header_size = file_.number<std::uint32_t>(begin);
    if (header_size > largest_header) throw Damage(begin, "the header of a record is damaged");
    file_.read(begin + 4, buffer_, header_size);
    const Fields fields = read_fields(buffer_, begin);
    const std::uint64_t data = begin + 8 + header_size;
    const std::uint32_t size = file_.number<std::uint32_t>(data - 4);
    at_ = data + size;
    if (fields.kind == chunk) {
      container_ = chunks_.add({data, size, fields.size, compression_named(fields.compression, begin)});
      at_in_chunk_ = 0;
      return std::nullopt;
    }
    if (at_ > file_.size()) throw Damage(file_.size(), "the file ends in a record");
    if (fields.kind == bag_header) was_closed_ = fields.index_offset > 0;
    if (fields.kind == connection) {
      if (size > largest_header) throw Damage(begin, "a connection is damaged");
      file_.read(data, buffer_, size);
      add_connection(fields, buffer_, begin);
    }
    if (fields.kind == message) return found(fields, {0, Place::no_container, data, size}, begin);
    return std::nullopt;
  }

  std::optional<MessagePlace> next_in_chunk() {
    const Bytes bytes = chunks_.bytes(container_);
    const std::uint64_t begin = chunks_.chunk(container_).offset;
    while (at_in_chunk_ < bytes.size()) {
      const bool is_cut = at_ > file_.size();
      Bytes header, data;
      std::size_t data_offset = 0;
      try {
        ByteReader reader(bytes.subspan(at_in_chunk_));
        header = reader.sequence();
        const std::uint32_t size = reader.number<std::uint32_t>();
        data_offset = at_in_chunk_ + reader.position();
        data = reader.take(size);
        at_in_chunk_ = data_offset + size;
      } catch (const std::runtime_error&) {
        throw is_cut ? Damage(file_.size(), "the file ends in a chunk")
                     : Damage(begin, "a record in a chunk is damaged");
      }
      const Fields fields = read_fields(header, begin);
      if (fields.kind == connection) add_connection(fields, data, begin);
      if (fields.kind == message) return found(fields, {0, container_, data_offset, data.size()}, begin);
    }
    return std::nullopt;
  }

  void add_connection(const Fields& fields, Bytes data, std::uint64_t begin) {
    const Fields more = read_fields(data, begin);
    if (fields.topic.empty()) throw Damage(begin, "a connection has no topic");
    connections_[fields.connection] = topic_index({fields.topic, more.type, Serialization::ros1});
  }
  MessagePlace found(const Fields& fields, const Place& place, std::uint64_t begin) const {
    const auto known = connections_.find(fields.connection);
    if (known == connections_.end()) throw Damage(begin, "a message belongs to no connection");
    return {known->second, place};
  }

  static constexpr std::uint32_t largest_header = 1 << 24;  // with the definition of a message

  BagFile file_;
  ChunkStore chunks_;
  std::map<std::uint32_t, std::size_t> connections_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t at_ = ros1_magic.size();
  std::uint32_t container_ = Place::no_container;
  std::size_t at_in_chunk_ = 0;
  bool was_closed_ = true;
};

}  // namespace plumbline::io::bag
