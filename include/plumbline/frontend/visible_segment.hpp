#pragma once
/// Where the image shows a segment in space, cut to the part of it that it shows.

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// The segment from p to q [m] (coordinates of the middle of the frame's camera) in the image; false when nothing of it
/// is inside. Cut at a sixteenth of its length, which is right for every camera and behind it.
template <SensorRig Sensors>
bool visible_segment(const View<Sensors>& view, const Vec<typename Sensors::Scalar, 3>& p,
                     const Vec<typename Sensors::Scalar, 3>& q, LineSegment& out) {
  using S = typename Sensors::Scalar;
  constexpr int parts = 16;
  constexpr float border_px = 4;
  const auto see = [&](int k, Vec<float, 2>& uv) {
    const Vec<S, 3> at = p + (S(k) / S(parts)) * (q - p);
    const Projection<S> projection = view.camera().project(at);
    if (!projection.valid) return false;
    uv = cast_to<float>(view.shutter.seen(projection.uv, S(1) / norm(at)));
    return view.current.level(0).contains(uv.x(), uv.y(), border_px);
  };
  int first = 0, last = parts;
  while (first < last && !see(first, out.start)) ++first;
  while (first < last && !see(last, out.end)) --last;
  return first < last;
}

}  // namespace plumbline
