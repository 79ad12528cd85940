#pragma once
/// What is printed: printf into a string of up to 511 characters, angles in degrees.

#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

inline constexpr double degrees = 57.29577951308232;  ///< of a radian

[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  std::array<char, 512> text{};
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}
