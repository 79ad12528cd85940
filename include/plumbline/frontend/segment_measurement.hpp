#pragma once
/// Observation of a line from an image segment: rays through its ends, and their covariance normal to the segment.
///                                                                                            docs/math/line.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// `covariance`: of the displacements of both ends normal to the segment [px^2]. Not valid where the camera has no
/// rays.
template <SensorRig Sensors, class Observation>
void measure_segment(const View<Sensors>& view, const LineSegment& segment, const Mat<float, 2, 2>& covariance,
                     Observation& out) {
  using S = typename Sensors::Scalar;
  out.valid = false;
  const Vec<S, 2> start = cast_to<S>(segment.start), end = cast_to<S>(segment.end);
  // The inverse ranges of the previous frame are accurate enough for the correction of the shutter.
  const typename Observation::Derivatives before = out.derivatives.get();
  const LineObservation<S> seen = observe_line(view.camera(), view.shutter.still(start, before[0].inverse_range).uv,
                                               view.shutter.still(end, before[1].inverse_range).uv);
  if (!seen.valid) return;
  const SegmentMeasurement<LineReprojection<S>> pixels(seen.reprojection, cast_to<S>(covariance));
  out.valid = pixels.valid;
  if (!out.valid) return;
  out.pixels = pixels;
  out.segment = segment;
  if constexpr (Sensors::rolls) {
    out.derivatives.set(
        {view.shutter.bearing_derivative(start, seen.reprojection.bearing_start, before[0].inverse_range),
         view.shutter.bearing_derivative(end, seen.reprojection.bearing_end, before[1].inverse_range)});
  }
}

}  // namespace plumbline
