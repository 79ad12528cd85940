#pragma once
/// Counts of what a keyframe map has done.

namespace plumbline {

/// What a map has done so far.
struct KeyframeMapCounts {
  int queries = 0, verified = 0, loops = 0, corrections = 0;
  int rejected_by_gate = 0, rejected_by_tilt = 0, rejected_as_ambiguous = 0, relocalizations = 0, evicted = 0;
  int recalled = 0, adjustments = 0;       ///< points found again, local bundle adjustments
  int frames_asked = 0, frames_found = 0;  ///< single frames without a pose of their own, and those with one in the map
};

}  // namespace plumbline
