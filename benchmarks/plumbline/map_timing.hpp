#pragma once
/// Durations of the stages of a map's work.

/// On one frame [s]; zero without a map. They are part of the durations in FrameTiming.
struct MapTiming {
  double learn = 0;   ///< descriptors of a new keyframe, and what a retired one leaves
  double query = 0;   ///< keyframes that look like the newest one
  double verify = 0;  ///< pose in one of them, and the tests of that pose
  double solve = 0;   ///< a part of the pose graph's solution

  double total() const { return learn + query + verify + solve; }
};
