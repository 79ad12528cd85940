#pragma once
/// Segments of two images paired by binary descriptors: mutually nearest, and of similar direction.
///
/// The directions carry the polarity (line_segment.hpp), so that an edge is not matched with its own other side. The
/// work is the product of the numbers of segments.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline::opencv {

/// 256 tests of one bit.
using LineDescriptor = std::array<std::uint64_t, 4>;

inline int hamming_distance(const LineDescriptor& a, const LineDescriptor& b) {
  int bits = 0;
  for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(a[i] ^ b[i]);
  return bits;
}

/// X. Zhao, C. Miao, H. Zhang (2020), section 2.3 have 30 degrees and 60 bits alone (`max_ratio` 1).
struct LineMatchOptions {
  float max_angle_rad = 0.5236f;  ///< between the directions
  int max_distance = 60;          ///< below this many bits that differ
  float max_ratio = 0.8f;         ///< below this part of the distance to the second nearest
  float min_length_ratio = 0;     ///< of the shorter segment to the longer one
  float max_shift_px = std::numeric_limits<float>::infinity();  ///< of the center
};

struct LineMatch {
  std::size_t first, second;  ///< indices
  int distance;               ///< bits that differ
};

namespace detail {

inline bool may_match(const LineSegment& a, const LineSegment& b, const LineMatchOptions& options) {
  const float la = a.length(), lb = b.length();
  return a.direction().dot(b.direction()) > std::cos(options.max_angle_rad) &&
         std::min(la, lb) >= options.min_length_ratio * std::max(la, lb) &&
         (a.center() - b.center()).norm() <= options.max_shift_px;
}

/// The nearest of the others that may match, and how near it and the next one are.
struct Nearest {
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
};

}  // namespace detail

/// Pairs in the order of the first image's segments; no segment is in two of them. Descriptor i is that of segment i.
inline std::vector<LineMatch> match_lines(std::span<const LineSegment> first,
                                          std::span<const LineDescriptor> first_descriptors,
                                          std::span<const LineSegment> second,
                                          std::span<const LineDescriptor> second_descriptors,
                                          const LineMatchOptions& options = {}) {
  PLUMBLINE_ASSERT(first.size() == first_descriptors.size() && second.size() == second_descriptors.size());
  std::vector<detail::Nearest> of_first(first.size()), of_second(second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (!detail::may_match(first[i], second[j], options)) continue;
      const int distance = hamming_distance(first_descriptors[i], second_descriptors[j]);
      of_first[i].offer(j, distance);
      of_second[j].offer(i, distance);
    }
  }
  const auto is_distinct = [&](const detail::Nearest& n) {
    return static_cast<float>(n.distance) < options.max_ratio * static_cast<float>(n.second_distance);
  };
  std::vector<LineMatch> matches;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const detail::Nearest& nearest = of_first[i];
    if (!(nearest.distance < options.max_distance)) continue;
    const detail::Nearest& back = of_second[nearest.index];
    if (back.index == i && is_distinct(nearest) && is_distinct(back)) {
      matches.push_back({i, nearest.index, nearest.distance});
    }
  }
  return matches;
}

}  // namespace plumbline::opencv
