#pragma once
/// Association of the points in view with the segments of an image.                         docs/math/collinear.md

#include <algorithm>
#include <array>
#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// `Members`: a list of {id, hint}, hint the index in the store; points beyond the first `capacity` are not associated.
template <class Members, int capacity = 1024>
class PointsOnSegments {
 public:
  /// Associates each point in view with the segments within `within_px`, at most two (a corner); with none if there are
  /// more.
  void associate(const auto& points, const auto& segments, float within_px) {
    segments_of_.clear();
    for (const auto& point : points.landmarks()) {
      Pair on{none, none};
      std::size_t fits = 0;
      for (std::size_t k = 0; point.current.valid && k < segments.size(); ++k) {
        if (!(distance_to(segments[k], point.current.pixel) < within_px)) continue;
        if (fits < on.size()) on[fits] = static_cast<int>(k);
        ++fits;
      }
      segments_of_.push_back(fits > on.size() ? Pair{none, none} : on);
    }
  }

  /// The points of a segment, up to the capacity of Members.
  Members of(std::size_t segment, const auto& points) const {
    Members out;
    for (std::size_t i = 0; i < segments_of_.size(); ++i) {
      const Pair& on = segments_of_[i];
      if (on[0] == static_cast<int>(segment) || on[1] == static_cast<int>(segment))
        out.push_back({.id = points.landmarks()[i].id, .hint = static_cast<int>(i)});
    }
    return out;
  }

 private:
  using Pair = std::array<int, 2>;
  static constexpr int none = -1;

  /// Distance of a pixel to a segment, not to its infinite line [px].
  static float distance_to(const LineSegment& segment, const Vec<float, 2>& uv) {
    const Vec<float, 2> extent = segment.end - segment.start, off = uv - segment.start;
    const float along = std::clamp(dot(off, extent) / squared_norm(extent), 0.0f, 1.0f);
    return norm(off - along * extent);
  }

  FixedVector<Pair, capacity> segments_of_;  ///< of each point, by its index in the store
};

}  // namespace plumbline
