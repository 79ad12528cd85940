#pragma once
/// Index of keyframes by what they look like: it gives the keyframes that share the most descriptors with an image.
///                                                                                docs/math/place_recognition.md
///   index.add(id, descriptors)          false: the index is full, or has that id
///   index.remove(id)                    false: it has no such id
///   index.query(descriptors, out)       the best candidates into `out`, the best one first; returns how many
///   index.query(descriptors, out, accept)    among the keyframes with accept(id)
///
/// Scores of different queries compare: one threshold serves a run. A candidate is a hypothesis: geometric verification
/// decides.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

struct PlaceCandidate {
  std::uint32_t id = 0;  ///< of the keyframe
  float score = 0;       ///< in [0, 1]
};

/// `max_keyframes` and `max_descriptors` (of one keyframe) are part of the type; further descriptors are left out.
template <class I>
concept PlaceIndex = requires(I index, const I& constant, std::uint32_t id, std::span<const BinaryDescriptor> seen,
                              std::span<PlaceCandidate> out, bool (*accept)(std::uint32_t)) {
  { I::max_keyframes } -> std::convertible_to<std::size_t>;
  { I::max_descriptors } -> std::convertible_to<std::size_t>;
  { index.add(id, seen) } -> std::same_as<bool>;
  { index.remove(id) } -> std::same_as<bool>;
  { index.query(seen, out) } -> std::same_as<std::size_t>;
  { index.query(seen, out, accept) } -> std::same_as<std::size_t>;
  { constant.size() } -> std::same_as<std::size_t>;
  { constant.contains(id) } -> std::same_as<bool>;
  index.clear();
};

}  // namespace plumbline
