#pragma once
/// Counts the rows of an index file that are skipped, by reason, and says so in one line for each reason.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/text.hpp"

namespace plumbline::io {

class SkippedRows {
 public:
  /// `detail` is of the first row only.
  void add(const RowReader& row, std::string_view why, std::string_view detail = "") {
    for (Reason& reason : reasons_) {
      if (reason.why != why) continue;
      ++reason.count;
      return;
    }
    reasons_.push_back({std::string(why), std::string(detail), row.line(), 1});
  }

  /// Notes of the form "file: 3 of 240 rows are skipped: why (first: line 7)". More than half of the rows skipped for
  /// one reason are a ReadError at the first of them.
  void report(const std::filesystem::path& file, std::size_t rows, std::vector<std::string>& notes) const {
    for (const Reason& reason : reasons_) {
      const std::string share = std::to_string(reason.count) + " of " + std::to_string(rows) + " rows";
      if (2 * reason.count > rows) throw ReadError(file, reason.line, reason.why + reason.detail + " (" + share + ")");
      notes.push_back(file.string() + ": " + share + (reason.count == 1 ? " is" : " are") + " skipped: " + reason.why +
                      reason.detail + " (" + (reason.count == 1 ? "line " : "first: line ") +
                      std::to_string(reason.line) + ")");
    }
  }

 private:
  struct Reason {
    std::string why, detail;
    int line;
    std::size_t count;
  };
  std::vector<Reason> reasons_;
};

}  // namespace plumbline::io
