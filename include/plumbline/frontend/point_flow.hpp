#pragma once
/// Front end of points by optical flow and feature alignment: flow tracks a point from image to image; alignment with
/// its patch in the anchor, warped by the estimated motion, removes the drift of the track. Landmarks out of view stay
/// in the store and are searched near their projections by the estimated pose.
///                                                                            docs/math/tracking.md, docs/math/point.md

#include <algorithm>
#include <cstddef>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/point_flow_options.hpp"
#include "plumbline/frontend/point_location.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "plumbline/tracking/surface_slant.hpp"

namespace plumbline {

template <class Store>
class PointFlow {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  using Options = PointOptionsOf<Sensors>;
  static constexpr bool gives_correspondences = true;
  static constexpr bool relates_two_views = true;  ///< by for_each_pair

  explicit PointFlow(const PointFlowOptions& options) : options_(options) {}

  void follow(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_predicted) {
    const SE3<S> T_cam_world = (T_world_predicted * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid) continue;
      const Vec<float, 2> guess = expected(view, window, landmark, T_cam_world);
      const FlowResult flow =
          track_point_checked(view.previous, view.current, landmark.current.pixel, guess, options_.flow);
      observe(view, landmark, flow.valid, flow.uv);
    }
  }

  /// take(index, correspondence) for every located landmark observed by the frame.
  void for_each_correspondence(const View<Sensors>& view, const auto& window, const Store& store, auto&& take) const {
    const S sigma_rad = S(options_.sigma_flow_px) / effective_focal_length(view.camera());
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      const Landmark& landmark = store.landmarks()[i];
      if (!landmark.current.valid || !landmark.located) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      PoseCorrespondence<S> correspondence{ray.bearing, p_world(landmark, window, view.T_body_cam), sigma_rad};
      if (const InverseDepth<S>& depth = landmark.current.depth.get(); depth.valid) {
        correspondence.inverse_depth = depth.value;
        correspondence.sigma_inverse_depth = elementary::hypot(depth.sigma, landmark.geometry.sigma_inverse_range);
      }
      take(static_cast<int>(i), correspondence);
    }
  }

  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    int searches = 0;
    // The search begins at another landmark in every frame, so that none is left out permanently.
    auto& landmarks = store.landmarks();
    const std::size_t n = landmarks.size();
    for (std::size_t k = 0; k < n; ++k) {
      Landmark& landmark = landmarks[(k + first_search_) % n];
      if (!landmark.located) continue;
      const bool tracked = landmark.current.valid;
      if (!tracked && searches >= options_.max_searches) continue;
      const SE3<S> T_cam_anchor = T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam);
      const Vec<S, 3> p_cam = T_cam_anchor * Kind::middle(landmark.geometry);
      const Projection<S> predicted = view.camera().project(p_cam);
      if (!predicted.valid) continue;
      const Vec<S, 2> seen = view.shutter.seen(predicted.uv, S(1) / norm(p_cam));
      if (!inside(view, seen, border_px) || view.current.mask().excludes(cast_to<float>(seen))) continue;
      if (!tracked) ++searches;
      const auto& point = landmark.geometry;
      const auto& [patch, slant] = landmark.appearance;
      const Mat<float, 2, 2> A =
          affine_warp(view.camera(), view.camera(), point.bearing, S(1) / point.inverse_range, T_cam_anchor)
              .slanted(slant.a());
      const Vec<float, 2> start = tracked ? landmark.current.pixel : seen.template cast<float>();
      AlignmentOptions alignment = options_.alignment;
      alignment.coarse_start = !tracked;
      const Alignment aligned = align_patch(patch, A, view.current, start, alignment);
      if (tracked) {
        if (!aligned.valid || !(norm(aligned.uv - start) < options_.max_drift_px)) continue;
      }
      observe(view, landmark, aligned);
    }
    if (n > 0) first_search_ = (first_search_ + static_cast<std::size_t>(options_.max_searches)) % n;
  }

  /// Locates points by measured depth or by triangulation, point_location.hpp.
  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    const S sigma_rad = S(options_.sigma_flow_px) / effective_focal_length(view.camera());
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      const SE3<S> T_cam_anchor = T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam);
      locate_from_depth(landmark, ray.bearing, T_cam_anchor);
      if (landmark.located) continue;
      locate_from_views(landmark, view, window, ray.bearing, T_cam_anchor, sigma_rad, options_.min_views,
                        options_.triangulation);
    }
  }

  /// In a keyframe: locates points by its depth, updates the surface slants of landmarks in view, and adds new
  /// landmarks at corners away from those in view.
  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot) {
    const SE3<S> T_world_cam = window.T_world_body(slot) * view.T_body_cam, T_cam_world = T_world_cam.inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      locate_from_depth(landmark, ray.bearing, T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam));
    }
    update_slants(view, window, store, T_cam_world);
    in_view_.clear();
    for (const Landmark& landmark : store.landmarks()) {
      if (landmark.current.valid) in_view_.push_back(landmark.current.pixel);
    }
    corners_.clear();
    detect_corners(view.current.level(0), in_view_.data(), in_view_.size(), options_.corners, corners_,
                   view.current.mask());
    int missing = options_.target_count - static_cast<int>(in_view_.size());
    for (const Corner& corner : corners_) {
      if (missing <= 0) break;
      Landmark landmark;
      observe(view, landmark, true, corner.uv);
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid || !landmark.appearance.patch.capture(view.current, corner.uv)) continue;
      auto& point = landmark.geometry;
      point.bearing = ray.bearing;
      point.derivative.set(view.shutter.bearing_derivative(corner.uv.template cast<S>(), ray.bearing, S(0)));
      if (const InverseDepth<S>& depth = landmark.current.depth.get(); depth.valid) {
        landmark.located = true;
        point.inverse_range = depth.value * ray.bearing.z();
        point.sigma_inverse_range = depth.sigma * ray.bearing.z();
      }
      if (!store.add(landmark, slot)) break;
      --missing;
    }
  }

  /// visit(bearing in the anchor, bearing now) for every landmark anchored in `slot` that the frame observes.
  void for_each_pair(const View<Sensors>& view, const Store& store, int slot, auto&& visit) const {
    for (const Landmark& landmark : store.landmarks()) {
      if (landmark.anchor != slot || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (ray.valid) visit(landmark.geometry.bearing, ray.bearing);
    }
  }

  // For other front ends of points.

  /// Predicted pixel of a landmark in view of the previous image; its previous pixel if the prediction is outside the
  /// image.
  static Vec<float, 2> expected(const View<Sensors>& view, const auto& window, const Landmark& landmark,
                                const SE3<S>& T_cam_world) {
    Vec<S, 3> p_cam;
    S inverse_range = S(landmark.current.derivative.get().inverse_range);
    if (landmark.located) {
      p_cam = T_cam_world * p_world(landmark, window, view.T_body_cam);
      inverse_range = S(1) / norm(p_cam);
    } else {
      const SO3<S> R_cam_previous = T_cam_world.rotation() * (view.T_world_previous * view.T_body_cam).rotation();
      p_cam = R_cam_previous * view.camera().unproject(landmark.current.uv.template cast<S>()).bearing;
    }
    const Projection<S> predicted = view.camera().project(p_cam);
    if (!predicted.valid) return landmark.current.pixel;
    const Vec<S, 2> seen = view.shutter.seen(predicted.uv, inverse_range);
    return inside(view, seen, 0) ? Vec<float, 2>(seen.template cast<float>()) : landmark.current.pixel;
  }

  /// Sets the current observation from feature alignment, with its information; not valid if the alignment failed.
  void observe(const View<Sensors>& view, Landmark& landmark, const Alignment& aligned) const {
    observe(view, landmark, aligned.valid, aligned.uv);
    constexpr float least_rms = 0.25f;  // numerics: quantization of intensities, about 1/sqrt(12)
    const float sigma_intensity = float(options_.sigma_residual) * std::max(aligned.rms, least_rms);
    if (aligned.valid)
      landmark.current.L = whitening_of(aligned.information_per_intensity, float(options_.sigma_px), sigma_intensity);
  }
  /// Sets the current observation at `pixel` with the sigma of optical flow and measured depth, or as not valid; that
  /// of an excluded pixel is not one of the static scene.
  void observe(const View<Sensors>& view, Landmark& landmark, bool valid, const Vec<float, 2>& pixel) const {
    typename Kind::Observation& seen = landmark.current;
    seen.valid = valid && !view.current.mask().excludes(pixel);
    if (!seen.valid) {
      ++landmark.misses;
      return;
    }
    landmark.misses = 0;
    // The inverse range of the previous frame is accurate enough for the correction of the shutter.
    const StillPixel<S> still = view.shutter.still(pixel.template cast<S>(), S(seen.derivative.get().inverse_range));
    seen.pixel = pixel;
    seen.uv = still.uv.template cast<float>();
    seen.derivative.set({cast_to<float>(still.derivative.by_rotation), cast_to<float>(still.derivative.by_translation),
                         float(still.derivative.inverse_range)});
    seen.L = identity<float, 2>() / float(options_.sigma_flow_px);
    if constexpr (Sensors::has_depth) seen.depth.set(view.rig.vision.depth.at(view.depth, pixel));
  }

 private:
  /// geometry: half an alignment patch and the interpolation's neighbor.
  static constexpr float border_px = 8;

  static bool inside(const View<Sensors>& view, const Vec<S, 2>& uv, float border) {
    return view.current.level(0).contains(float(uv.x()), float(uv.y()), border);
  }
  static Vec<S, 3> p_world(const Landmark& landmark, const auto& window, const SE3<S>& T_body_cam) {
    return window.T_world_body(landmark.anchor) * (T_body_cam * Kind::middle(landmark.geometry));
  }

  /// Updates the surface slants of the located landmarks in view.
  void update_slants(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_cam_world) const {
    const float f = float(effective_focal_length(view.camera()));
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid || !landmark.located) continue;
      const AffineWarp warp =
          affine_warp(view.camera(), view.camera(), landmark.geometry.bearing, S(1) / landmark.geometry.inverse_range,
                      T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam));
      auto& [patch, slant] = landmark.appearance;
      slant.learn(slant_equations(patch, warp, slant.a(), view.current, landmark.current.pixel), f, options_.slant);
    }
  }

  PointFlowOptions options_;
  FixedVector<Vec<float, 2>, Store::capacity> in_view_;
  FixedVector<Corner, Store::capacity> corners_;
  std::size_t first_search_ = 0;
};

}  // namespace plumbline
