#pragma once
/// Text of others (file names, content of files) made fit for a terminal and for one line.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace plumbline::io {

/// Length of the UTF-8 character that the text begins with; 0 if it begins with none.
inline std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  if (text.empty()) return 0;
  const std::size_t length = byte(0) < 0x80   ? 1
                             : byte(0) < 0xC2 ? 0
                             : byte(0) < 0xE0 ? 2
                             : byte(0) < 0xF0 ? 3
                             : byte(0) < 0xF5 ? 4
                                              : 0;
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  return length;
}

/// The text with `\n` and the like for its control characters, also those of two bytes, and for what is no UTF-8.
inline std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const auto first = static_cast<std::uint8_t>(text[0]);
    const bool is_control =
        length == 1 ? first < 0x20 || first == 0x7F : length == 2 && first == 0xC2 && std::uint8_t(text[1]) < 0xA0;
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    if (length > 0 && !is_control) {
      out += character;
    } else if (first == '\n' || first == '\t') {
      out += first == '\n' ? "\\n" : "\\t";
    } else {
      for (const char c : character)
        out += {'\\', 'x', digits[static_cast<std::uint8_t>(c) >> 4], digits[static_cast<std::uint8_t>(c) & 15]};
    }
    text.remove_prefix(character.size());
  }
  return out;
}

}  // namespace plumbline::io
