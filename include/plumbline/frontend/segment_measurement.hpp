#pragma once
/// A segment of the image as an observation: rays through its ends, and how sure they are across it.
///                                                                                            docs/math/line.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// `covariance` of the distances of both ends across the segment [px^2]. Not valid where the camera sees no rays.
template <SensorRig Sensors, class Observation>
void measure_segment(const View<Sensors>& view, const LineSegment& segment, const Mat<float, 2, 2>& covariance,
                     Observation& out) {
  using S = typename Sensors::Scalar;
  out.valid = false;
  const Vec<S, 2> start = cast_to<S>(segment.start), end = cast_to<S>(segment.end);
  // Where it was a frame ago: there it is now, as far as the shutter minds.
  const typename Observation::Slopes before = out.slopes.get();
  const LineObservation<S> seen = observe_line(view.camera(), view.shutter.still(start, before[0].inverse_range).uv,
                                               view.shutter.still(end, before[1].inverse_range).uv);
  if (!seen.valid) return;
  const SegmentMeasurement<LineReprojection<S>> pixels(seen.reprojection, cast_to<S>(covariance));
  out.valid = pixels.valid;
  if (!out.valid) return;
  out.pixels = pixels;
  out.segment = segment;
  if constexpr (Sensors::rolls) {
    out.slopes.set({view.shutter.bearing_slope(start, seen.reprojection.bearing_start, before[0].inverse_range),
                    view.shutter.bearing_slope(end, seen.reprojection.bearing_end, before[1].inverse_range)});
  }
}

}  // namespace plumbline
