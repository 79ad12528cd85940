#include "stream_message.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <poll.h>
#include <unistd.h>
#include <zlib.h>

#include "interrupt.hpp"

namespace {

const char* name_of(MessageType type) {
  switch (type) {
    case MessageType::calibration: return "calibration";
    case MessageType::imu: return "imu";
    case MessageType::frame: return "frame";
    case MessageType::depth: return "depth";
    case MessageType::end: return "end";
    case MessageType::estimate: return "estimate";
    case MessageType::event: return "event";
    case MessageType::map: return "map";
  }
  return "unknown";
}

bool is_input(MessageType type) { return type >= MessageType::calibration && type <= MessageType::end; }

std::uint32_t checksum(std::span<const std::uint8_t> header, std::span<const std::uint8_t> payload) {
  const uLong of_header = crc32(crc32(0, nullptr, 0), header.data(), 12);
  if (payload.empty()) return static_cast<std::uint32_t>(of_header);  // zlib takes no data for a new sum
  return static_cast<std::uint32_t>(crc32(of_header, payload.data(), static_cast<uInt>(payload.size())));
}

}  // namespace

std::string name_of(const Message& message) {
  return "message " + std::to_string(message.number) + " (" + name_of(message.type) + ")";
}

StreamError::StreamError(const Message& message, const std::string& what)
    : StreamError(name_of(message) + ": " + what) {}

bool MessageReader::read(std::span<std::uint8_t> out, const std::string& what, bool may_end) {
  for (std::size_t done = 0; done < out.size();) {
    pollfd ready{fd_, POLLIN, 0};
    if (stop_ || Interruptible::is_asked_to_stop()) return false;
    const int events = poll(&ready, 1, 100);
    if (events == 0 || (events < 0 && errno == EINTR)) continue;
    const ssize_t n = ::read(fd_, out.data() + done, out.size() - done);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n < 0) throw StreamError(what + ": cannot be read: " + std::strerror(errno));
    if (n == 0 && may_end && done == 0) return false;
    if (n == 0)
      throw StreamError(what + " is cut off: " + std::to_string(done) + " of " + std::to_string(out.size()) +
                        " bytes are there");
    done += static_cast<std::size_t>(n);
  }
  return true;
}

std::optional<Message> MessageReader::next() {
  Message out;
  out.number = ++count_;
  const std::string number = "message " + std::to_string(count_);
  std::array<std::uint8_t, Message::header_size> header{};
  if (!read(header, "the header of " + number, true)) {
    if (stop_ || Interruptible::is_asked_to_stop()) return std::nullopt;
    throw StreamError("ends after " + std::to_string(count_ - 1) + " messages without an end message");
  }
  if (std::memcmp(header.data(), "PLBL", 4) != 0)
    throw StreamError(number + " does not begin with PLBL: the stream is damaged, or of another program");
  if (header[4] != Message::version)
    throw StreamError(number + " is of version " + std::to_string(header[4]) + ", read is version " +
                      std::to_string(Message::version));
  out.type = static_cast<MessageType>(header[5]);
  out.encoding = static_cast<std::uint16_t>(header[6] | header[7] << 8);
  if (!is_input(out.type)) throw StreamError(number + ": type " + std::to_string(header[5]) + " is unknown");
  const std::uint32_t length = number_at<std::uint32_t>(header, 8);
  if (length > Message::max_length)
    throw StreamError(out,
                      std::to_string(length) + " bytes, at most " + std::to_string(Message::max_length) + " are read");
  // By parts: a length that is wrong does not take memory for data that never comes.
  constexpr std::size_t part = 1 << 20;
  while (out.payload.size() < length) {
    const std::size_t before = out.payload.size();
    out.payload.resize(std::min<std::size_t>(length, before + part));
    const std::span<std::uint8_t> rest = std::span(out.payload).subspan(before);
    if (!read(rest, name_of(out), false)) return std::nullopt;
  }
  if (checksum(header, out.payload) != number_at<std::uint32_t>(header, 12))
    throw StreamError(out, "damaged: its checksum is wrong");
  return out;
}

std::vector<std::uint8_t> bytes_of(MessageType type, std::uint16_t encoding, std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> out{'P',
                                'L',
                                'B',
                                'L',
                                Message::version,
                                static_cast<std::uint8_t>(type),
                                static_cast<std::uint8_t>(encoding & 255),
                                static_cast<std::uint8_t>(encoding >> 8)};
  append_number(out, static_cast<std::uint32_t>(payload.size()));
  append_number(out, checksum(out, payload));
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
