#pragma once
// Bags as their specifications have them, written from messages: the other side of what is tested.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <bzlib.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include "plumbline/core/time.hpp"
#include "plumbline/io/bag/byte_reader.hpp"
#include "plumbline/io/bag/mcap_file.hpp"

namespace test {

using plumbline::TimeNs;
using plumbline::io::bag::Serialization;

// Appends numbers and texts, as ROS 1 or CDR has them.
class MessageWriter {
 public:
  explicit MessageWriter(Serialization serialization, bool is_big = false)
      : is_cdr_(serialization == Serialization::cdr), is_big_(is_big) {
    if (is_cdr_) bytes = {'\0', is_big ? '\0' : '\1', '\0', '\0'};
  }
  template <class Number>
  MessageWriter& add(Number value) {
    while (is_cdr_ && (bytes.size() - 4) % sizeof value != 0) bytes += '\0';
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    for (std::size_t i = 0; i < sizeof value; ++i) bytes += raw[is_big_ ? sizeof value - 1 - i : i];
    return *this;
  }
  MessageWriter& text(const std::string& value) {
    add(static_cast<std::uint32_t>(value.size() + is_cdr_));
    bytes += value;
    if (is_cdr_) bytes += '\0';
    return *this;
  }
  MessageWriter& data(const std::string& value) {
    add(static_cast<std::uint32_t>(value.size()));
    bytes += value;
    return *this;
  }
  MessageWriter& header(TimeNs t_ns) {
    if (!is_cdr_) add(std::uint32_t{7});
    add(static_cast<std::uint32_t>(t_ns / 1'000'000'000)).add(static_cast<std::uint32_t>(t_ns % 1'000'000'000));
    return text("camera");
  }

  std::string bytes;

 private:
  bool is_cdr_, is_big_;
};

inline std::string image_message(Serialization s, TimeNs t_ns, int width, int height, const std::string& encoding,
                                 const std::string& pixels, bool is_big = false) {
  MessageWriter out(s, is_big);
  out.header(t_ns).add(static_cast<std::uint32_t>(height)).add(static_cast<std::uint32_t>(width)).text(encoding);
  out.add(std::uint8_t{0}).add(static_cast<std::uint32_t>(pixels.size() / static_cast<std::size_t>(height)));
  return out.data(pixels).bytes;
}
inline std::string compressed_message(Serialization s, TimeNs t_ns, const std::string& format,
                                      const std::string& file) {
  return MessageWriter(s).header(t_ns).text(format).data(file).bytes;
}
inline std::string imu_message(Serialization s, TimeNs t_ns, double gyro_x, double accel_z, bool is_big = false) {
  MessageWriter out(s, is_big);
  out.header(t_ns);
  for (int i = 0; i < 13; ++i) out.add(0.0);
  for (const double x : {gyro_x, 0.0, 0.0}) out.add(x);
  for (int i = 0; i < 9; ++i) out.add(0.0);
  for (const double x : {0.0, 0.0, accel_z}) out.add(x);
  for (int i = 0; i < 9; ++i) out.add(0.0);
  return out.bytes;
}
inline std::string camera_info_message(Serialization s, TimeNs t_ns, int width, int height) {
  MessageWriter out(s);
  out.header(t_ns).add(static_cast<std::uint32_t>(height)).add(static_cast<std::uint32_t>(width)).text("plumb_bob");
  out.add(std::uint32_t{5});
  for (const double x : {-0.25, 0.125, 0.0, 0.0, 0.0}) out.add(x);
  for (const double x : {16.0, 0.0, width / 2.0, 0.0, 17.0, height / 2.0, 0.0, 0.0, 1.0}) out.add(x);
  for (int i = 0; i < 21; ++i) out.add(0.0);
  for (int i = 0; i < 6; ++i) out.add(std::uint32_t{0});
  out.add(std::uint8_t{0});
  return out.bytes;
}

struct WrittenMessage {
  TimeNs t_ns;
  std::string topic, type;  // "Image"
  std::string bytes;
};

inline std::string number(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += i < 8 ? static_cast<char>(value >> 8 * i) : '\0';
  return out;
}
inline std::string counted(const std::string& bytes, int size = 4) { return number(bytes.size(), size) + bytes; }

inline std::string compressed(const std::string& bytes, const std::string& by) {
  if (by == "none" || by.empty()) return bytes;
  std::string out(bytes.size() + bytes.size() / 50 + 1000, '\0');
  std::size_t size = 0;
  if (by == "bz2") {
    unsigned length = static_cast<unsigned>(out.size());
    if (BZ2_bzBuffToBuffCompress(out.data(), &length, const_cast<char*>(bytes.data()),
                                 static_cast<unsigned>(bytes.size()), 9, 0, 0) != BZ_OK)
      throw std::runtime_error("bz2");
    size = length;
  } else if (by == "lz4") {
    size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  } else {
    size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3);
  }
  out.resize(size);
  return out;
}

// Chunks of so many messages.
constexpr std::size_t messages_of_chunk = 10;

inline std::string ros1_bag(const std::vector<WrittenMessage>& messages, const std::string& compression) {
  const auto field = [](const std::string& name, const std::string& value) { return counted(name + "=" + value); };
  const auto record = [](const std::string& header, const std::string& data) {
    return counted(header) + counted(data);
  };
  std::string out = "#ROSBAG V2.0\n";
  out += record(field("op", "\3") + field("index_pos", number(4242, 8)) + field("conn_count", number(1, 4)) +
                    field("chunk_count", number(1, 4)),
                std::string(64, ' '));
  std::vector<std::string> connections;
  std::string chunk;
  std::size_t in_chunk = 0;
  const auto end_chunk = [&] {
    out += record(field("op", "\5") + field("compression", compression) + field("size", number(chunk.size(), 4)),
                  compressed(chunk, compression));
    out += record(field("op", "\4") + field("ver", number(1, 4)), std::string(12, '\0'));  // an index
    chunk.clear();
    in_chunk = 0;
  };
  for (const WrittenMessage& message : messages) {
    std::size_t id = 0;
    while (id < connections.size() && connections[id] != message.topic) ++id;
    if (id == connections.size()) {
      connections.push_back(message.topic);
      chunk += record(field("op", "\7") + field("conn", number(id, 4)) + field("topic", message.topic),
                      field("topic", message.topic) + field("type", "sensor_msgs/" + message.type) +
                          field("md5sum", "0") + field("message_definition", "none"));
    }
    chunk += record(field("op", "\2") + field("conn", number(id, 4)) + field("time", number(0, 8)), message.bytes);
    if (++in_chunk == messages_of_chunk) end_chunk();
  }
  if (in_chunk > 0) end_chunk();
  return out;
}

inline std::string mcap_file(const std::vector<WrittenMessage>& messages, const std::string& compression) {
  const auto record = [](int kind, const std::string& data) {
    return std::string(1, static_cast<char>(kind)) + counted(data, 8);
  };
  std::string out(plumbline::io::bag::mcap_magic);
  out += record(1, counted("ros2") + counted("test"));
  std::vector<std::string> channels;
  std::string chunk;
  std::size_t in_chunk = 0;
  const auto end_chunk = [&] {
    const std::uint32_t crc =
        plumbline::io::bag::crc32({reinterpret_cast<const std::uint8_t*>(chunk.data()), chunk.size()});
    out +=
        record(6, number(0, 16) + number(chunk.size(), 8) + number(crc, 4) +
                      counted(compression == "none" ? "" : compression) + counted(compressed(chunk, compression), 8));
    chunk.clear();
    in_chunk = 0;
  };
  for (const WrittenMessage& message : messages) {
    std::size_t id = 0;
    while (id < channels.size() && channels[id] != message.topic) ++id;
    if (id == channels.size()) {
      channels.push_back(message.topic);
      chunk +=
          record(3, number(id + 1, 2) + counted("sensor_msgs/msg/" + message.type) + counted("ros2msg") + counted(""));
      chunk += record(4, number(id, 2) + number(id + 1, 2) + counted(message.topic) + counted("cdr") + number(0, 4));
    }
    chunk += record(5, number(id, 2) + number(0, 4) + number(0, 16) + message.bytes);
    if (++in_chunk == messages_of_chunk) end_chunk();
  }
  if (in_chunk > 0) end_chunk();
  out += record(15, number(0, 4)) + record(2, number(0, 20));
  return out + std::string(plumbline::io::bag::mcap_magic);
}

inline void write_sqlite(const std::filesystem::path& file, const std::vector<WrittenMessage>& messages) {
  std::filesystem::remove(file);
  sqlite3* database = nullptr;
  sqlite3_open(file.c_str(), &database);
  const auto run = [&](const std::string& text) {
    if (sqlite3_exec(database, text.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(database));
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB); BEGIN");
  std::vector<std::string> topics;
  for (const WrittenMessage& message : messages) {
    std::size_t id = 0;
    while (id < topics.size() && topics[id] != message.topic) ++id;
    if (id == topics.size()) {
      topics.push_back(message.topic);
      run("INSERT INTO topics VALUES (" + std::to_string(id) + ", '" + message.topic + "', 'sensor_msgs/msg/" +
          message.type + "', 'cdr')");
    }
    std::string hex;
    for (const char byte : message.bytes) {
      char text[3];
      std::snprintf(text, sizeof text, "%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
      hex += text;
    }
    run("INSERT INTO messages(topic_id, timestamp, data) VALUES (" + std::to_string(id) + ", 0, x'" + hex + "')");
  }
  run("COMMIT");
  sqlite3_close(database);
}

struct BagFormat {
  std::string name, compression;
  Serialization serialization;
};
inline const std::vector<BagFormat> bag_formats = {
    {"ros1", "none", Serialization::ros1}, {"ros1", "bz2", Serialization::ros1}, {"ros1", "lz4", Serialization::ros1},
    {"mcap", "none", Serialization::cdr},  {"mcap", "lz4", Serialization::cdr},  {"mcap", "zstd", Serialization::cdr},
    {"sqlite", "", Serialization::cdr}};

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}
inline void write_bag(const std::filesystem::path& file, const BagFormat& format,
                      const std::vector<WrittenMessage>& messages) {
  if (format.name == "sqlite")
    write_sqlite(file, messages);
  else
    write_bytes(
        file, format.name == "ros1" ? ros1_bag(messages, format.compression) : mcap_file(messages, format.compression));
}

// Frames at 20 Hz, gray of 32 x 24 and depth of the same size, IMU samples at 100 Hz, a calibration.
constexpr int width = 32, height = 24, frames = 12;
constexpr TimeNs begin_ns = 1'600'000'000'000'000'000;
inline TimeNs frame_ns(int i) { return begin_ns + i * TimeNs{50'000'000}; }
inline std::string gray_pixels(int frame) {
  std::string out;
  for (int i = 0; i < width * height; ++i) out += static_cast<char>((i * 7 + frame * 31) % 251);
  return out;
}
inline std::vector<WrittenMessage> robot_messages(Serialization s, bool with_depth = true) {
  std::vector<WrittenMessage> out;
  out.push_back({begin_ns, "/cam/camera_info", "CameraInfo", camera_info_message(s, begin_ns, width, height)});
  for (int i = 0; i < frames; ++i) {
    const TimeNs t = frame_ns(i);
    for (int k = 0; k < 5; ++k)
      out.push_back({t, "/imu", "Imu", imu_message(s, t + k * 10'000'000, 0.01 * (5 * i + k), 9.81)});
    out.push_back({t, "/cam/image_raw", "Image", image_message(s, t, width, height, "mono8", gray_pixels(i))});
    const std::string raw(2 * width * height, static_cast<char>(4 + i));
    if (with_depth)
      out.push_back({t, "/cam/depth", "Image", image_message(s, t + 1'000'000, width, height, "16UC1", raw)});
    out.push_back({t, "/chatter", "String", "hello"});
  }
  return out;
}

}  // namespace test
