#pragma once
/// Minimal samples for a consensus of many items of which some are wrong.                   docs/math/geometry.md (6)

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/elementary.hpp"
#include "plumbline/core/random.hpp"

namespace plumbline {

/// K different indices below n, each set of them with the same probability (Floyd).
template <std::size_t K>
std::array<std::uint32_t, K> random_sample(Random& random, std::uint32_t n) {
  PLUMBLINE_ASSERT(n >= K);
  std::array<std::uint32_t, K> index{};
  for (std::size_t k = 0; k < K; ++k) {
    const std::uint32_t newest = n - static_cast<std::uint32_t>(K - k), drawn = random.below(newest + 1);
    const auto end = index.begin() + static_cast<std::ptrdiff_t>(k);
    index[k] = std::find(index.begin(), end, drawn) == end ? drawn : newest;
  }
  return index;
}

/// How many samples of that size hold one without a wrong item with this confidence, when this part of the items is
/// right. Infinite when none is.
inline double samples_needed(double confidence, double right, int size) {
  double w = 1;
  for (int k = 0; k < size; ++k) w *= right;
  if (w >= 1) return 0;
  return elementary::log1p(-confidence) / elementary::log1p(-w);
}

}  // namespace plumbline
