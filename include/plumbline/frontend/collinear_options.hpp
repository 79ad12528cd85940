#pragma once
/// Options of lines through points (collinear_segments.hpp), and those of a rig.                docs/math/collinear.md

#include <cstddef>

#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"

namespace plumbline {

struct CollinearOptions {
  int target_count = 60;  ///< new lines are added until this many are in view; tuned: docs/decisions/136 (chosen)
  /// Sigma of an endpoint normal to the segment that the length of the edge does not reduce [px];
  /// tuned: docs/decisions/042.
  float sigma_px = 0.4f;
  /// Distance of edge points with independent errors [px]; geometry: closer peaks share pixels.
  float peak_spacing_px = 4;
  /// Largest distance of a member to its segment [px]; corners are detected beside their edges;
  /// tuned: docs/decisions/047.
  float member_px = 4;
  /// Fewest members of a line, at least two; a line with fewer is discarded; tuned: docs/decisions/146.
  std::size_t min_points = 2;
  /// Smallest distance of two shared members in both views of a line [px]; tuned: docs/decisions/136 (chosen).
  float separation_px = 10;
  /// Largest distance between a segment and the projection of its line [px]; tuned: docs/decisions/048.
  float same_line_px = 2;
  /// Factor on the sigmas of members that replace a segment, because they are also used as points;
  /// tuned: docs/decisions/136 (chosen).
  double sigma_points = 3;
  LineDetectorOptions detector;
  LineTrackingOptions tracking;  ///< options for tracking the edge of a detected segment
};

/// Those of a rig. Two points always fit a line, so nothing tests them: without an IMU a line needs three;
/// tuned: docs/decisions/146.
template <SensorRig Sensors>
struct CollinearOptionsOf : CollinearOptions {
  constexpr CollinearOptionsOf() {
    if (!Sensors::has_imu) min_points = 3;
  }
};

}  // namespace plumbline
