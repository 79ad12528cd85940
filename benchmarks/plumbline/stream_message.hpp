#pragma once
/// Messages of `plumbline live`, in both directions: a header of 16 bytes and a payload, numbers little-endian.
///
///   "PLBL"  version  type  encoding  length      CRC-32 (IEEE 802.3) of the 12 bytes before it and the payload
///   4       u8 = 1   u8    u16       u32         u32                                              docs/guide/live.md

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

enum class MessageType : std::uint8_t { calibration = 1, imu, frame, depth, end, estimate = 16, event, map };

struct Message {
  static constexpr std::size_t header_size = 16, max_length = 64 << 20;
  static constexpr std::uint8_t version = 1;

  MessageType type;
  std::uint16_t encoding = 0;
  std::size_t number = 0;  ///< in the stream, from 1
  std::vector<std::uint8_t> payload;
};

/// "stream: message 12 (frame): what is wrong".
class StreamError : public std::runtime_error {
 public:
  explicit StreamError(const std::string& what) : std::runtime_error("stream: " + what) {}
  StreamError(const Message& message, const std::string& what);
};

/// "message 12 (frame)".
std::string name_of(const Message& message);

/// Reads messages from a file descriptor, checked whole, until `stop` or a signal asks to stop.
class MessageReader {
 public:
  MessageReader(int fd, const std::atomic<bool>& stop) : fd_(fd), stop_(stop) {}

  /// Nothing after that. Throws StreamError: damage, a cut message, or the end of input before an end message.
  std::optional<Message> next();

 private:
  /// False when stopped, and where `may_end` and input ends before the first byte.
  bool read(std::span<std::uint8_t> out, const std::string& what, bool may_end);

  int fd_;
  const std::atomic<bool>& stop_;
  std::size_t count_ = 0;
};

/// A message as bytes.
std::vector<std::uint8_t> bytes_of(MessageType type, std::uint16_t encoding, std::span<const std::uint8_t> payload);

/// The number at a place of a payload.
template <class T>
T number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  static_assert(sizeof(T) == sizeof(Bits));
  Bits value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= Bits{bytes[at + i]} << (8 * i);
  return std::bit_cast<T>(value);
}
template <class T>
void append_number(std::vector<std::uint8_t>& bytes, T number) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  static_assert(sizeof(T) == sizeof(Bits));
  const Bits value = std::bit_cast<Bits>(number);
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
