#pragma once
/// MCAP files: records of a kind, a length and content; schemas and channels name the topics, chunks hold the messages.
/// Read from the begin to the end of the data, without the index, so that a file that was never closed is read as well.

#include <algorithm>
#include <array>
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

inline constexpr std::string_view mcap_magic("\x89MCAP0\r\n", 8);

/// CRC-32 as zlib and MCAP have it.
inline std::uint32_t crc32(Bytes bytes) {
  static constexpr std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> out{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = value & 1 ? 0xEDB88320U ^ value >> 1 : value >> 1;
      out[i] = value;
    }
    return out;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) crc = table[(crc ^ byte) & 0xFF] ^ crc >> 8;
  return ~crc;
}

class McapFile final : public BagReader {
 public:
  explicit McapFile(const std::filesystem::path& path) : file_(path), chunks_(file_) {}

  std::optional<MessagePlace> next() override {
    while (!is_end_) {
      if (container_ != Place::no_container) {
        if (const auto found = next_in_chunk()) return found;
        container_ = Place::no_container;
        if (at_ > file_.size()) throw Damage(file_.size(), "the file ends in a chunk");
        continue;
      }
      if (at_ >= file_.size()) throw Damage(file_.size(), "the file ends before the end of its data");
      if (const auto found = next_in_file()) return found;
    }
    return std::nullopt;
  }
  Bytes read(const Place& place, std::size_t at_most) override { return chunks_.read(place, at_most); }
  void release() override { chunks_.release(); }

 private:
  enum Kind : int { footer = 2, schema = 3, channel = 4, message = 5, chunk = 6, data_end = 15 };
  static constexpr std::size_t message_head = 22;           // channel, counter, two times
  static constexpr std::uint64_t largest_record = 1 << 24;  // of a schema or a channel

  std::optional<MessagePlace> next_in_file() {
    const std::uint64_t begin = at_;
    const int kind = file_.number<std::uint8_t>(begin);
    const std::uint64_t size = file_.number<std::uint64_t>(begin + 1), data = begin + 9;
    if (kind == 0) throw Damage(begin, "a record has no kind");
    if (kind == chunk) {
      if (size < 40) throw Damage(begin, "a chunk is damaged");
      open_chunk(begin, data, size);
      return std::nullopt;
    }
    if (size > file_.left_from(data)) throw Damage(file_.size(), "the file ends in a record");
    at_ = data + size;
    if (kind == footer || kind == data_end) is_end_ = true;
    if (kind == schema || kind == channel || kind == message) {
      if (kind != message && size > largest_record) throw Damage(begin, "a record of a topic is damaged");
      file_.read(data, buffer_, kind == message ? std::min<std::uint64_t>(size, message_head) : size);
      return take_in(kind, buffer_, {0, Place::no_container, data, size}, begin);
    }
    return std::nullopt;
  }

  void open_chunk(std::uint64_t begin, std::uint64_t data, std::uint64_t size) {
    file_.read(data, buffer_, std::min<std::uint64_t>({size, 64, file_.left_from(data)}));
    try {
      ByteReader reader(buffer_);
      reader.take(16);  // times
      Chunk found;
      found.size = reader.number<std::uint64_t>();
      const std::uint32_t crc = reader.number<std::uint32_t>();
      found.compression = compression_named(reader.text(), begin);
      found.stored_size = reader.number<std::uint64_t>();
      found.offset = data + reader.position();
      if (found.stored_size != size - reader.position()) throw Damage(begin, "a chunk is damaged: its sizes differ");
      at_ = found.offset + found.stored_size;
      if (at_ < found.offset) throw Damage(begin, "a chunk is damaged: its size is too large");
      container_ = chunks_.add(found);
      at_in_chunk_ = 0;
      const Bytes bytes = chunks_.bytes(container_);
      if (crc != 0 && at_ <= file_.size() && crc32(bytes) != crc)
        throw Damage(begin, "a chunk is damaged: its check sum is another");
    } catch (const Damage&) {
      container_ = Place::no_container;
      throw;
    } catch (const std::runtime_error&) {
      throw Damage(begin, "the header of a chunk is damaged");
    }
  }

  std::optional<MessagePlace> next_in_chunk() {
    const Bytes bytes = chunks_.bytes(container_);
    const std::uint64_t begin = chunks_.chunk(container_).offset;
    while (at_in_chunk_ < bytes.size()) {
      int kind = 0;
      Bytes content;
      std::size_t offset = 0;
      try {
        ByteReader reader(bytes.subspan(at_in_chunk_));
        kind = reader.number<std::uint8_t>();
        const std::uint64_t size = reader.number<std::uint64_t>();
        offset = at_in_chunk_ + reader.position();
        content = reader.take(static_cast<std::size_t>(size));
        at_in_chunk_ = offset + content.size();
      } catch (const std::runtime_error&) {
        throw at_ > file_.size() ? Damage(file_.size(), "the file ends in a chunk")
                                 : Damage(begin, "a record in a chunk is damaged");
      }
      if (const auto found = take_in(kind, content, {0, container_, offset, content.size()}, begin)) return found;
    }
    return std::nullopt;
  }

  /// Of a message `content` may be its head alone.
  std::optional<MessagePlace> take_in(int kind, Bytes content, Place place, std::uint64_t begin) {
    try {
      ByteReader reader(content);
      const auto id = kind == schema || kind == channel || kind == message ? reader.number<std::uint16_t>() : 0;
      if (kind == schema) schemas_[id] = reader.text();
      if (kind == channel) {
        const auto of_schema = schemas_.find(reader.number<std::uint16_t>());
        const std::string topic(reader.text()), encoding(reader.text());
        const std::string type = of_schema == schemas_.end() ? "" : of_schema->second;
        const bool is_read = encoding == "cdr" || encoding == "ros1";
        channels_[id] = topic_index({topic, is_read ? type : type + " (" + encoding + ")",
                                     encoding == "ros1" ? Serialization::ros1 : Serialization::cdr});
      }
      if (kind == message) {
        reader.take(message_head - 2);
        const auto of_channel = channels_.find(id);
        if (of_channel == channels_.end()) throw Damage(begin, "a message belongs to no channel");
        place.offset += message_head;
        place.size -= message_head;
        return MessagePlace{of_channel->second, place};
      }
    } catch (const Damage&) {
      throw;
    } catch (const std::runtime_error&) {
      throw Damage(begin, "a record is damaged");
    }
    return std::nullopt;
  }

  BagFile file_;
  ChunkStore chunks_;
  std::map<int, std::string> schemas_;
  std::map<int, std::size_t> channels_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t at_ = mcap_magic.size();
  std::uint32_t container_ = Place::no_container;
  std::size_t at_in_chunk_ = 0;
  bool is_end_ = false;
};

}  // namespace plumbline::io::bag
