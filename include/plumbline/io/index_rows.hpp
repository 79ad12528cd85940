#pragma once
/// What the readers of index files share: rows that are skipped, surplus columns, units of time stamps.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/io/skipped_rows.hpp"
#include "plumbline/io/text.hpp"
#include "plumbline/io/time_unit.hpp"

namespace plumbline::io::detail {

using Path = std::filesystem::path;

inline std::optional<Path> if_exists(const Path& file) {
  return std::filesystem::exists(file) ? std::optional<Path>(file) : std::nullopt;
}

/// Whether t lies after the last of the items already read; else the row is counted as skipped.
template <class Items>
bool is_after(const RowReader& row, const Items& items, TimeNs t, SkippedRows& skipped) {
  if (items.empty() || t > items.back().t_ns) return true;
  skipped.add(row, t == items.back().t_ns ? "the time stamp is that of the row above"
                                          : "the time stamp is before that of the row above");
  return false;
}

/// Whether the row has its columns; says once where it has more.
inline bool has_columns(const RowReader& row, std::size_t n, const Path& file, SkippedRows& skipped,
                        std::vector<std::string>& notes, bool& is_said) {
  if (row.size() < n)
    skipped.add(row, "expected " + std::to_string(n) + " columns, found " + std::to_string(row.size()));
  if (row.size() > n && !std::exchange(is_said, true))
    notes.push_back(file.string() + ":" + std::to_string(row.line()) + ": found " + std::to_string(row.size()) +
                    " columns, those after column " + std::to_string(n) + " are ignored");
  return row.size() >= n;
}

/// The unit of a file's time stamps; says so where it is not the layout's.
inline TimeUnit unit_of(const Path& file, TimeUnit expected, std::vector<std::string>& notes) {
  const TimeUnit unit = unit_of_times(file, expected);
  if (unit != expected)
    notes.push_back(file.string() + ": the time stamps are in " + name_of(unit) + " (expected " + name_of(expected) +
                    ")");
  return unit;
}

/// The first of these files that exists; the first of all where none does.
inline Path first_existing(const std::vector<Path>& files) {
  for (const Path& file : files)
    if (std::filesystem::exists(file)) return file;
  return files.front();
}

}  // namespace plumbline::io::detail
