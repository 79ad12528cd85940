#pragma once
/// Progress of long work on stderr: a line that is rewritten on a terminal, one line every 10 % elsewhere.

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include "plumbline/io/printable.hpp"

class Progress {
 public:
  Progress(std::string what, std::size_t total) : what_(std::move(what)), total_(total) {}

  /// A line of its own between those of the progress.
  void note(const std::string& text) {
    std::fprintf(stderr, "%s%s\n", is_terminal_ ? "\r\033[K" : "", plumbline::io::printable(text).c_str());
  }

  void show(std::size_t done) {
    const std::size_t percent = total_ == 0 ? 100 : 100 * done / total_;
    const std::size_t step = is_terminal_ ? 1 : 10;
    if (percent / step == shown_percent_ / step) return;
    shown_percent_ = percent;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double left_s = done == 0 ? 0 : seconds * static_cast<double>(total_ - done) / static_cast<double>(done);
    std::fprintf(stderr, "%s%s: %3zu %% (%zu of %zu, %.1f s, %.0f s left)%s", is_terminal_ ? "\r\033[K" : "",
                 what_.c_str(), percent, done, total_, seconds, left_s, is_terminal_ && done != total_ ? "" : "\n");
  }

 private:
  std::string what_;
  std::size_t total_, shown_percent_ = 0;
  bool is_terminal_ = isatty(STDERR_FILENO) == 1;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};
