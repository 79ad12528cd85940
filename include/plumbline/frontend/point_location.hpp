#pragma once
/// Initialization of a point: from the depth measured along its bearing, or by triangulation from the latest frame and
/// the keyframes that observed it.                                                          docs/math/geometry.md 4

#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The inverse range of a landmark from the depth measured along `bearing` in the latest frame.
template <class Landmark, class S>
void locate_from_depth(Landmark& landmark, const Vec<S, 3>& bearing, const SE3<S>& T_cam_anchor) {
  const InverseDepth<S>& depth = landmark.current.depth.get();
  if (!depth.valid) return;
  const Vec<S, 3> p_anchor = T_cam_anchor.inverse() * Vec<S, 3>(bearing / (depth.value * bearing.z()));
  const S range = norm(p_anchor);
  // The direction from the anchor to the measured point must agree with the bearing in the anchor.
  constexpr S min_cosine = S(0.999);  // geometry: 2.6 degrees
  if (!(dot(p_anchor, landmark.geometry.bearing) > min_cosine * range)) return;
  landmark.located = true;
  landmark.geometry.inverse_range = S(1) / range;
  landmark.geometry.sigma_inverse_range = depth.sigma * bearing.z();
}

/// The inverse range of a landmark by triangulation from the latest frame, which sees it along `bearing`. With
/// `min_views` > 1 the views of all keyframes that observed it, except its anchor, are included; there must be so many.
template <SensorRig Sensors, class Landmark, class S>
void locate_from_views(Landmark& landmark, const View<Sensors>& view, const auto& window, const Vec<S, 3>& bearing,
                       const SE3<S>& T_cam_anchor, S sigma_rad, int min_views, const TriangulationOptions& options) {
  constexpr std::size_t slots = std::tuple_size_v<decltype(landmark.observations)>;
  FixedVector<TriangulationView<S>, slots + 1> views;
  views.push_back({T_cam_anchor, bearing, sigma_rad});
  if (min_views > 1) {
    const SE3<S> T_world_anchor = window.T_world_body(landmark.anchor) * view.T_body_cam;
    for (int slot = 0; slot < int(slots); ++slot) {
      const auto& seen = landmark.observations[static_cast<std::size_t>(slot)];
      if (slot == landmark.anchor || !seen.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(seen.uv.template cast<S>());
      const SE3<S> T_cam_world = (window.T_world_body(slot) * view.T_body_cam).inverse();
      if (ray.valid) views.push_back({T_cam_world * T_world_anchor, ray.bearing, sigma_rad});
    }
  }
  if (static_cast<int>(views.size()) < min_views) return;
  const std::span<const TriangulationView<S>> all(views.data(), views.size());
  const Triangulation<S> found = triangulate<S>(landmark.geometry.bearing, all, options);
  if (!found.valid) return;
  landmark.located = true;
  landmark.geometry.inverse_range = found.inverse_range;
  landmark.geometry.sigma_inverse_range = std::sqrt(found.variance);
}

}  // namespace plumbline
