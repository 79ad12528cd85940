#pragma once
/// The depth filters of landmarks that have no place in space yet, each found by the landmark's id.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumbline {

/// As many as there may be landmarks. Ids are given in order, so that two with one place among the filters are rare: the
/// later call begins anew.
template <class Filter, int Capacity>
class Seeds {
 public:
  /// A new one, of which nothing is known, where the landmark had none.
  Filter& of(std::uint32_t id) {
    Seed& seed = seeds_[id % static_cast<std::size_t>(Capacity)];
    if (seed.id != id) seed = {id, {}};
    return seed.filter;
  }

 private:
  struct Seed {
    std::uint32_t id = std::numeric_limits<std::uint32_t>::max();
    Filter filter;
  };
  std::array<Seed, Capacity> seeds_;
};

}  // namespace plumbline
