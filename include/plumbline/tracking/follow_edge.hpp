#pragma once
/// Extension of a straight edge from its end, while the gradient is consistent with it.     docs/math/line.md
///
/// Each step of 1 px needs a derivative along the normal that is larger than those 2 px to both sides, with its peak
/// near the line. The peak is added to the line's moments, and the line is fitted again every few pixels.

#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/tracking/edge_queries.hpp"
#include "plumbline/tracking/line_fit.hpp"

namespace plumbline {

struct FollowOptions {
  float min_slope;        ///< along the normal [intensity/px]
  float max_distance_px;  ///< of a peak to the line
  int max_misses;         ///< pixels in a row without an edge
  int max_steps;          ///< [px]
};

/// Moves `tip` along the line (sign 1) or against it (-1) to the end of the edge. The line, its moments and the tip are
/// relative to the pixel `origin`; the line's normal (-d_y, d_x) points to the brighter side.
template <class Edges>
void follow_edge(const Edges& edges, const Vec<float, 2>& origin, const FollowOptions& options, float sign,
                 FittedLine& line, LineMoments<float>& moments, Vec<float, 2>& tip) {
  constexpr int refit_interval = 8;
  int misses = 0, added = 0;
  for (int k = 0; k < options.max_steps && misses <= options.max_misses; ++k) {
    const Vec<float, 2> at = line.at(line.along(tip) + sign * static_cast<float>(1 + misses));
    const Vec<float, 2> normal(-line.direction.y(), line.direction.x()), uv = origin + at;
    const float slope = edges.aligned_slope(uv, normal);
    ++misses;
    if (!(slope > options.min_slope && slope > edges.aligned_slope(uv - 2 * normal, normal) &&
          slope > edges.aligned_slope(uv + 2 * normal, normal))) {
      continue;
    }
    const Vec<float, 2> peak = edges.peak(nearest_pixel(uv)) - origin;
    if (!(std::abs(line.distance(peak)) < options.max_distance_px)) continue;
    misses = 0;
    tip = at;
    moments.add(peak.x(), peak.y());
    if (++added % refit_interval != 0) continue;
    const Vec<float, 2> direction = line.direction;
    line = moments.line();
    if (dot(line.direction, direction) < 0) line.direction = -line.direction;
  }
}

}  // namespace plumbline
