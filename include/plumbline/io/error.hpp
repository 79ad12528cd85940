#pragma once
/// The error where a file cannot be used: one line, "file:line: what is wrong".

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "plumbline/io/printable.hpp"

namespace plumbline::io {

class ReadError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0 where the fault has no line (a missing file, a missing key).
  ReadError(const std::filesystem::path& file, int line, std::string_view what)
      : std::runtime_error(
            printable(file.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + std::string(what))) {}
};

}  // namespace plumbline::io
