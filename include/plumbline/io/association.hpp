#pragma once
/// Pairs two increasing lists of times: the closest pairs first, each time used once, as the TUM benchmark's tool does.
///
/// A time midway between two others has two equally good partners. The known tools compare seconds as doubles, so that
/// the rounding of the subtraction decides; so it does here, or the figures would differ from theirs in the sixth
/// digit.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "plumbline/core/time.hpp"

namespace plumbline::io {

using IndexPairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// Seconds as a double, rounded once.
inline double seconds(TimeNs t) {
  const TimeNs whole = t / 1'000'000'000;
  return static_cast<double>(whole) + static_cast<double>(t % 1'000'000'000) * 1e-9;
}

/// Pairs (i, j) with |a[i] - b[j]| <= max_difference_ns, in order of i.
inline IndexPairs associate_times(const std::vector<TimeNs>& a, const std::vector<TimeNs>& b,
                                  TimeNs max_difference_ns) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> candidates;  // difference, i, j
  std::size_t first = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    while (first < b.size() && b[first] < a[i] - max_difference_ns) ++first;
    for (std::size_t j = first; j < b.size() && b[j] <= a[i] + max_difference_ns; ++j)
      candidates.emplace_back(std::abs(seconds(b[j]) - seconds(a[i])), i, j);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> a_used(a.size()), b_used(b.size());
  IndexPairs pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (a_used[i] || b_used[j]) continue;
    a_used[i] = b_used[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// The times of frames, poses or samples.
template <class Stamped>
std::vector<TimeNs> times_of(const std::vector<Stamped>& items) {
  std::vector<TimeNs> times;
  times.reserve(items.size());
  for (const Stamped& item : items) times.push_back(item.t_ns);
  return times;
}

}  // namespace plumbline::io
