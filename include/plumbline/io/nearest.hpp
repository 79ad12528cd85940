#pragma once
/// "Did you mean ...?": the known name nearest to a misspelled one, if one is near.

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::io {

/// Levenshtein distance: insertions, deletions and replacements of characters that turn `a` into `b`.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

/// The known name that differs from `name` in a third of its characters at most; empty if there is none.
template <class Names>
std::string_view nearest_name(std::string_view name, const Names& known) {
  constexpr std::size_t longest = 100;  // of a misspelled name
  std::string_view nearest;
  std::size_t distance = (name.size() + 2) / 3 + 1;
  for (const std::string_view each : known) {
    if (name.size() > longest) break;
    if (const std::size_t d = edit_distance(name, each); d < distance) {
      distance = d;
      nearest = each;
    }
  }
  return nearest;
}

/// `did you mean "b"?` where a name is near, else `known are a, b, c`.
template <class Names>
std::string suggestion(std::string_view name, const Names& known) {
  const std::string_view nearest = nearest_name(name, known);
  if (!nearest.empty()) return "did you mean \"" + std::string(nearest) + "\"?";
  std::string list;
  for (const std::string_view each : known) list += (list.empty() ? "known are " : ", ") + std::string(each);
  return list;
}

}  // namespace plumbline::io
