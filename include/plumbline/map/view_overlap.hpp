#pragma once
/// How much of what one keyframe sees another camera sees, too, by their poses alone.            docs/math/map.md 5

#include <algorithm>
#include <cstddef>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/place_keyframe.hpp"

namespace plumbline {

/// The part of the image plane z = 1 in which a keyframe has features.
struct SeenRectangle {
  float min_x = std::numeric_limits<float>::max(), max_x = -min_x, min_y = min_x, max_y = -min_x;

  template <class S, std::size_t N>
  explicit SeenRectangle(const PlaceKeyframe<S, N>& keyframe) {
    for (const PlaceFeature& feature : keyframe.features) {
      if (!(feature.bearing.z() > 0)) continue;
      const float x = feature.bearing.x() / feature.bearing.z(), y = feature.bearing.y() / feature.bearing.z();
      min_x = std::min(min_x, x);
      max_x = std::max(max_x, x);
      min_y = std::min(min_y, y);
      max_y = std::max(max_y, y);
    }
  }
  template <class S>
  bool contains(const Vec<S, 3>& p) const {
    return p.z() > S(0) && p.x() >= S(min_x) * p.z() && p.x() <= S(max_x) * p.z() && p.y() >= S(min_y) * p.z() &&
           p.y() <= S(max_y) * p.z();
  }
};

struct ViewOverlapOptions {
  double max_range_ratio = 1.8;  ///< of both ranges; descriptors are compared on pyramid levels of a factor of 2
  double min_cosine = 0.87;      ///< between both rays; 30 degrees: descriptors of corners change with the aspect
};

/// Share of the located features of `of` that a camera sees where T_camera_of is its pose, under a similar aspect.
template <class S, std::size_t N>
S view_overlap(const PlaceKeyframe<S, N>& of, const Sim3<S>& S_camera_of, const SeenRectangle& seen,
               const ViewOverlapOptions& options = {}) {
  int located = 0, visible = 0;
  for (const PlaceFeature& feature : of.features) {
    if (!feature.is_located()) continue;
    ++located;
    const Vec<S, 3> ray = S_camera_of.rotation() * cast_to<S>(feature.bearing);
    const S range_of = S_camera_of.scale() * S(feature.range);
    const Vec<S, 3> p = range_of * ray + S_camera_of.t();
    const S range = norm(p), most = S(options.max_range_ratio);
    visible += seen.contains(p) && range < most * range_of && range_of < most * range &&
               dot(p, ray) > S(options.min_cosine) * range;
  }
  return located > 0 ? S(visible) / S(located) : S(0);
}

}  // namespace plumbline
