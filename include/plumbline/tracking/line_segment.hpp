#pragma once
/// A straight edge in an image, and when two of them are one.                               docs/math/line.md
///
/// The direction carries the polarity: with d the unit direction from start to end, intensity grows along the normal
/// (-d_y, d_x). Two edges of opposite polarity are never the same.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct LineSegment {
  Vec<float, 2> start = zeros<float, 2>();  ///< [px]
  Vec<float, 2> end = zeros<float, 2>();    ///< [px]
  float gradient = 0;                       ///< mean gradient across the edge [intensity/px]

  float length() const { return norm(end - start); }                   ///< [px]
  Vec<float, 2> center() const { return 0.5f * (start + end); }        ///< [px]
  Vec<float, 2> direction() const { return normalized(end - start); }  ///< unit
  Vec<float, 2> normal() const {                                       ///< unit, toward the brighter side
    const Vec<float, 2> d = direction();
    return {-d.y(), d.x()};
  }
  /// Signed distance of a pixel to the infinite line, positive on the brighter side [px].
  float distance(const Vec<float, 2>& uv) const { return dot(normal(), uv - start); }
};

struct MergeOptions {
  float max_angle_rad = 0.05f;   ///< between the directions
  float max_distance_px = 1.2f;  ///< of the shorter one's endpoints to the longer one's line
  float max_gap_px = 12.0f;      ///< between the two along the line, and no more than ...
  float max_gap_ratio = 0.5f;    ///< ... this part of the shorter one
};

/// True when both are parts of one edge: same polarity, collinear, and overlapping or with a small gap.
inline bool are_one(const LineSegment& a, const LineSegment& b, const MergeOptions& options) {
  const LineSegment& longer = a.length() < b.length() ? b : a;
  const LineSegment& shorter = a.length() < b.length() ? a : b;
  const Vec<float, 2> d = longer.direction();
  if (!(dot(d, shorter.direction()) > elementary::cos(options.max_angle_rad))) return false;
  if (!(std::abs(longer.distance(shorter.start)) < options.max_distance_px &&
        std::abs(longer.distance(shorter.end)) < options.max_distance_px)) {
    return false;
  }
  const float from = dot(d, shorter.start - longer.start), to = dot(d, shorter.end - longer.start);
  const float gap = std::max(from - longer.length(), -to);  // negative when they overlap
  return gap < std::min(options.max_gap_px, options.max_gap_ratio * shorter.length());
}

/// Both as one: the line through the mass of both, as long as both together.
inline LineSegment merged(const LineSegment& a, const LineSegment& b) {
  const float wa = a.length(), wb = b.length();
  const Vec<float, 2> mean = (wa * a.center() + wb * b.center()) / (wa + wb);
  // Second moments of two uniform segments about the common mean.
  Mat<float, 2, 2> M = zeros<float, 2, 2>();
  for (const LineSegment* s : {&a, &b}) {
    const Vec<float, 2> c = s->center() - mean, h = 0.5f * (s->end - s->start);
    M += s->length() * (c * c.transpose() + h * h.transpose() / 3.0f);
  }
  const float angle = 0.5f * elementary::atan2(2 * M(0, 1), M(0, 0) - M(1, 1));
  Vec<float, 2> d(elementary::cos(angle), elementary::sin(angle));
  if (dot(d, a.end - a.start) < 0) d = -d;
  const auto along = [&](const Vec<float, 2>& uv) { return dot(d, uv - mean); };
  const float from = std::min({along(a.start), along(a.end), along(b.start), along(b.end)});
  const float to = std::max({along(a.start), along(a.end), along(b.start), along(b.end)});
  return {mean + from * d, mean + to * d, (wa * a.gradient + wb * b.gradient) / (wa + wb)};
}

/// Makes one of all that are one, longest first; what remains is sorted by length.
template <std::size_t N>
void merge_collinear(FixedVector<LineSegment, N>& segments, const MergeOptions& options) {
  const auto longer = [](const LineSegment& a, const LineSegment& b) {
    return squared_norm(a.end - a.start) > squared_norm(b.end - b.start);
  };
  std::sort(segments.begin(), segments.end(), longer);
  std::array<Vec<float, 2>, N> directions;
  for (std::size_t i = 0; i < segments.size(); ++i) directions[i] = segments[i].direction();
  const float min_cosine = elementary::cos(options.max_angle_rad);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t j = i + 1; j < segments.size();) {
      if (!(dot(directions[i], directions[j]) > min_cosine) || !are_one(segments[i], segments[j], options)) {
        ++j;
        continue;
      }
      segments[i] = merged(segments[i], segments[j]);
      directions[i] = segments[i].direction();
      segments.swap_remove(j);
      directions[j] = directions[segments.size()];
      j = i + 1;  // the longer one may meet others
    }
  }
  std::sort(segments.begin(), segments.end(), longer);
}

}  // namespace plumbline
