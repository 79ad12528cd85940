#pragma once
// A folder whose files a fuzz target writes anew in each run, and what a reader may throw.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "plumbline/io/error.hpp"
#include "temporary_directory.hpp"

/// Ends the program where a run does something that no input may cause.
inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "violated: %s\n", what);
  std::abort();
}

/// Calls f; of what it throws only a ReadError is right, in one line.
template <class F>
void expect_read_error_at_most(F&& f) {
  try {
    f();
  } catch (const plumbline::io::ReadError& error) {
    require(std::string_view(error.what()).find('\n') == std::string_view::npos, "an error is one line");
  }
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}
