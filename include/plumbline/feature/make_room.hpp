#pragma once
/// Room for new landmarks in a map that is full: the one out of sight that was looked for in vain most often goes, of
/// equals the oldest.

#include <algorithm>
#include <cstddef>

namespace plumbline {

/// False when the map is full and all of its landmarks are in sight.
template <class Landmarks>
bool make_room(Landmarks& landmarks) {
  if (!landmarks.full()) return true;
  const auto worst = std::max_element(landmarks.begin(), landmarks.end(), [](const auto& a, const auto& b) {
    if (a.current.valid != b.current.valid) return a.current.valid;
    return a.misses != b.misses ? a.misses < b.misses : a.id > b.id;
  });
  if (worst->current.valid) return false;
  landmarks.swap_remove(static_cast<std::size_t>(worst - landmarks.begin()));
  return true;
}

}  // namespace plumbline
