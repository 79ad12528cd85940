#pragma once
/// Table of the depth filters of landmarks that are not located yet, by landmark id.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumbline {

/// A table with one entry per possible landmark, indexed by id modulo capacity. Ids are consecutive, so collisions are
/// rare; on a collision the filter of the later id starts from the beginning.
template <class Filter, int Capacity>
class DepthFilters {
 public:
  /// The filter of a landmark; a new one if there was none.
  Filter& of(std::uint32_t id) {
    Entry& entry = filters_[id % static_cast<std::size_t>(Capacity)];
    if (entry.id != id) entry = {id, {}};
    return entry.filter;
  }

 private:
  struct Entry {
    std::uint32_t id = std::numeric_limits<std::uint32_t>::max();
    Filter filter;
  };
  std::array<Entry, Capacity> filters_;
};

}  // namespace plumbline
