#pragma once
/// Projection of a segment in space, clipped to the image.

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// Projects the segment from p to q [m], in the camera at the middle of the frame; false when nothing of it is inside
/// the image and outside its mask. It is clipped in steps of 1/16 of its length, which works for every camera model and
/// behind the camera.
template <SensorRig Sensors>
bool visible_segment(const View<Sensors>& view, const Vec<typename Sensors::Scalar, 3>& p,
                     const Vec<typename Sensors::Scalar, 3>& q, LineSegment& out) {
  using S = typename Sensors::Scalar;
  constexpr int parts = 16;       // numerics: ends to a sixteenth of the segment
  constexpr float border_px = 4;  // geometry: profiles of 4 px to both sides
  const auto project = [&](int k, Vec<float, 2>& uv) {
    const Vec<S, 3> at = p + (S(k) / S(parts)) * (q - p);
    const Projection<S> projection = view.camera().project(at);
    if (!projection.valid) return false;
    uv = cast_to<float>(view.shutter.seen(projection.uv, S(1) / norm(at)));
    return view.current.level(0).contains(uv.x(), uv.y(), border_px) && !view.current.mask().excludes(uv);
  };
  int first = 0, last = parts;
  while (first < last && !project(first, out.start)) ++first;
  while (first < last && !project(last, out.end)) --last;
  return first < last;
}

}  // namespace plumbline
