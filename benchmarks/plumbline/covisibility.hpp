#pragma once
/// Keyframes of a saved map that see the same features. A map does not keep this; it is found by projection of the
/// points of one keyframe into the other, and comparison of descriptors.

#include <cstddef>
#include <vector>

#include "plumbline/io/map_file.hpp"

struct Covisibility {
  std::size_t i, j;  ///< i < j
  std::size_t features;
};

/// For each keyframe the few others with which it has most features in common; each pair once, ordered by i and j.
std::vector<Covisibility> covisible_keyframes(const plumbline::io::MapContents& map);
