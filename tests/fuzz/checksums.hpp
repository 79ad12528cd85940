#pragma once
// Right checksums for damaged files, without which most of them would be refused at once.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "plumbline/map/archive_bytes.hpp"

/// A saved map ends with the checksum of all before it.
inline void repair_map(std::span<std::uint8_t> bytes) {
  if (bytes.size() < 4) return;
  const auto content = bytes.first(bytes.size() - 4);
  const std::uint32_t sum = plumbline::crc32(std::as_bytes(content));
  for (std::size_t i = 0; i < 4; ++i) bytes[content.size() + i] = static_cast<std::uint8_t>(sum >> 8 * i);
}

/// Each chunk of a PNG: length, type, data, checksum of the last two.
inline void repair_png(std::span<std::uint8_t> bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | bytes[at + i];
    if (length > bytes.size() - at - 12) return;
    const std::uint32_t sum = plumbline::crc32(std::as_bytes(bytes.subspan(at + 4, length + 4)));
    for (std::size_t i = 0; i < 4; ++i) bytes[at + 8 + length + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
    at += length + 12;
  }
}
