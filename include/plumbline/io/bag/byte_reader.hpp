#pragma once
/// Numbers and texts from a span of bytes, each checked against its end: CDR as ROS 2 serializes messages, and the
/// layout of ROS 1, which is the same without alignment and without zeros after texts.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace plumbline::io::bag {

using Bytes = std::span<const std::uint8_t>;

/// How a message is serialized.
enum class Serialization : std::uint8_t { ros1, cdr };

/// Throws std::runtime_error where the bytes end early.
class ByteReader {
 public:
  /// Little endian without alignment.
  explicit ByteReader(Bytes bytes) : bytes_(bytes) {}
  /// Of a message; CDR begins with four bytes that state the order of bytes.
  ByteReader(Bytes bytes, Serialization serialization) : bytes_(bytes) {
    if (serialization == Serialization::cdr) read_encapsulation();
  }

  std::size_t position() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }

  template <class Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number>);
    if (alignment_ > 1) align(sizeof(Number) < alignment_ ? sizeof(Number) : alignment_);
    const Bytes from = take(sizeof(Number));
    std::uint8_t ordered[sizeof(Number)];
    for (std::size_t i = 0; i < sizeof(Number); ++i)
      ordered[i] = from[is_big_ == (std::endian::native == std::endian::big) ? i : sizeof(Number) - 1 - i];
    Number out;
    std::memcpy(&out, ordered, sizeof out);
    return out;
  }
  /// Bytes without a count before them.
  Bytes take(std::size_t count) {
    if (count > left())
      throw std::runtime_error("ends after " + std::to_string(bytes_.size()) + " bytes, expected " +
                               std::to_string(count - left()) + " more");
    const Bytes out = bytes_.subspan(at_, count);
    at_ += count;
    return out;
  }
  /// A count of 32 bits and as many bytes.
  Bytes sequence() { return take(number<std::uint32_t>()); }
  std::string_view text() {
    const Bytes bytes = sequence();
    std::string_view out(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (alignment_ > 1 && out.ends_with('\0')) out.remove_suffix(1);
    return out;
  }
  std::vector<double> numbers(std::size_t count) {
    if (count > left() / sizeof(double))
      throw std::runtime_error("ends early: " + std::to_string(count) + " numbers expected");
    std::vector<double> out(count);
    for (double& value : out) value = number<double>();
    return out;
  }

 private:
  void read_encapsulation() {
    const Bytes head = take(4);
    const unsigned kind = 256U * head[0] + head[1];
    if (kind != 0 && kind != 1 && kind != 6 && kind != 7)
      throw std::runtime_error("is serialized in a way that is not read (encapsulation " + std::to_string(kind) + ")");
    is_big_ = kind % 2 == 0;
    alignment_ = kind < 2 ? 8 : 4;  // XCDR1, XCDR2
  }
  void align(std::size_t size) {
    const std::size_t over = (at_ - 4) % size;  // counted after the encapsulation
    if (over > 0) take(size - over);
  }

  Bytes bytes_;
  std::size_t at_ = 0, alignment_ = 1;
  bool is_big_ = false;
};

}  // namespace plumbline::io::bag
