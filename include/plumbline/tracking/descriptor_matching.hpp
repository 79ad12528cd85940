#pragma once
/// Pairs of binary descriptors: mutually nearest, and clearly nearer than the second nearest from both sides.
///                                                                                docs/math/place_recognition.md
///   d_ij <= d_ik,  d_ij <= d_kj  for all k,   d_ij <= d_max,
///   d_ij <= ratio min_{k != j} d_ik,   d_ij <= ratio min_{k != i} d_kj                                          (7)
/// The work is at most twice the product of the numbers of descriptors. Nothing is stored but the result.

#include <cstddef>
#include <limits>
#include <span>

#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

struct DescriptorMatchOptions {
  int max_distance = 64;   ///< [bits]
  float max_ratio = 0.8f;  ///< of the smallest distance to the second smallest; 1: no ratio test
};

struct DescriptorMatch {
  std::size_t first, second;  ///< indices
  int distance;               ///< [bits]
};

namespace detail {

/// The nearest of those offered, and the distance of the second nearest.
struct NearestDescriptor {
  static constexpr int none = std::numeric_limits<int>::max();
  std::size_t index = 0;
  int distance = none, second_distance = none;

  void offer(std::size_t i, int d) {
    if (d < distance) {
      second_distance = distance;
      distance = d;
      index = i;
    } else if (d < second_distance) {
      second_distance = d;
    }
  }
  bool passes(const DescriptorMatchOptions& options) const {
    return distance <= options.max_distance &&
           (second_distance == none ||
            static_cast<float>(distance) <= options.max_ratio * static_cast<float>(second_distance));
  }
};

}  // namespace detail

/// Writes the pairs (7) into `out` in the order of `first`, and returns how many; when `out` is full the rest is left
/// out. Only pairs with `may_match(i, j)` are compared, e.g. those near a predicted position.
template <class MayMatch>
std::size_t match_descriptors(std::span<const BinaryDescriptor> first, std::span<const BinaryDescriptor> second,
                              const DescriptorMatchOptions& options, std::span<DescriptorMatch> out,
                              MayMatch&& may_match) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < first.size() && found < out.size(); ++i) {
    detail::NearestDescriptor forward, backward;
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (may_match(i, j)) forward.offer(j, hamming_distance(first[i], second[j]));
    }
    if (!forward.passes(options)) continue;
    const std::size_t j = forward.index;
    for (std::size_t k = 0; k < first.size(); ++k) {
      if (may_match(k, j)) backward.offer(k, hamming_distance(first[k], second[j]));
    }
    if (backward.index == i && backward.passes(options)) out[found++] = {i, j, forward.distance};
  }
  return found;
}

inline std::size_t match_descriptors(std::span<const BinaryDescriptor> first, std::span<const BinaryDescriptor> second,
                                     const DescriptorMatchOptions& options, std::span<DescriptorMatch> out) {
  return match_descriptors(first, second, options, out, [](std::size_t, std::size_t) { return true; });
}

}  // namespace plumbline
