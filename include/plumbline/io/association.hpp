#pragma once
/// Pairs two increasing lists of times: the closest pairs first, each time used once, as the TUM benchmark's tool does.
///
/// A time midway between two others has two equally good partners. The known tools compare seconds as doubles, so that
/// the rounding of the subtraction decides; so it does here, or the figures would differ from theirs in the sixth
/// digit.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
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
///
/// The closest pair of all is adjacent when both lists are sorted into one; without it, the two times around it
/// do. So a queue of neighbors is enough, and memory grows with the times, however large the difference may be.
inline IndexPairs associate_times(const std::vector<TimeNs>& a, const std::vector<TimeNs>& b,
                                  TimeNs max_difference_ns) {
  struct Item {
    TimeNs t_ns;
    std::size_t index;  // in its list
    bool of_a;
    std::size_t before, after;  // those that are not paired yet
    bool paired = false;
  };
  std::vector<Item> items;
  for (std::size_t i = 0; i < a.size(); ++i) items.push_back({a[i], i, true, 0, 0});
  for (std::size_t j = 0; j < b.size(); ++j) items.push_back({b[j], j, false, 0, 0});
  std::sort(items.begin(), items.end(), [](const Item& x, const Item& y) { return x.t_ns < y.t_ns; });
  const std::size_t none = items.size();
  for (std::size_t k = 0; k < items.size(); ++k) {
    items[k].before = k == 0 ? none : k - 1;
    items[k].after = k + 1;
  }

  struct Candidate {
    std::tuple<double, std::size_t, std::size_t> rank;  // difference, i, j
    std::size_t first, second;                          // items
    bool operator>(const Candidate& other) const { return rank > other.rank; }
  };
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
  const auto consider = [&](std::size_t first, std::size_t second) {
    if (first == none || second == none) return;
    const Item &x = items[first], &y = items[second];
    if (x.of_a == y.of_a || y.t_ns - x.t_ns > max_difference_ns) return;
    const double difference = std::abs(seconds(x.t_ns) - seconds(y.t_ns));
    candidates.push({{difference, x.of_a ? x.index : y.index, x.of_a ? y.index : x.index}, first, second});
  };
  for (std::size_t k = 0; k + 1 < items.size(); ++k) consider(k, k + 1);

  IndexPairs pairs;
  while (!candidates.empty()) {
    const auto [rank, first, second] = candidates.top();
    candidates.pop();
    if (items[first].paired || items[second].paired) continue;
    items[first].paired = items[second].paired = true;
    pairs.emplace_back(std::get<1>(rank), std::get<2>(rank));
    const std::size_t before = items[first].before, after = items[second].after;
    if (before != none) items[before].after = after;
    if (after != none) items[after].before = before;
    consider(before, after);
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
