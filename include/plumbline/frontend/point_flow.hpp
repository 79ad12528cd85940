#pragma once
/// Points by optical flow and by their pixels in the anchor: flow finds them whatever the motion, the anchor's pixels,
/// warped as the estimated motion says, keep them from sliding. Landmarks out of sight stay in the store and are looked
/// for where the estimated pose puts them.                              docs/math/tracking.md, docs/math/point.md

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "plumbline/tracking/surface_slant.hpp"

namespace plumbline {

struct PointFlowOptions {
  double sigma_px = 0.2;  ///< of an aligned observation with all the texture one could wish
  /// Of a pixel, in root mean squares of what the alignment left of its patch: these errors are correlated.
  double sigma_residual = 4;
  double sigma_flow_px = 1.0;  ///< of a frame-to-frame observation
  int target_count = 180;      ///< corners are detected until this many landmarks are in sight
  int max_searches = 200;      ///< landmarks out of track that one frame looks for
  int min_views = 1;           ///< besides the anchor, that agree on where a point without depth is
  float max_drift_px = 2.0f;   ///< flow and alignment with the anchor may differ by this much
  OpticalFlowOptions flow;
  AlignmentOptions alignment;
  SlantOptions slant;
  CornerOptions corners;
  TriangulationOptions triangulation;
};

/// Of a rig: beside the readings of an IMU an aligned point must weigh what it is worth, or the scale follows their
/// errors. Where images are all there is only the weights among points matter. What moves with the camera has no depth,
/// and one view locates it as if it stood there.                            docs/math/point.md, docs/math/geometry.md 4
template <SensorRig Sensors>
struct PointOptionsOf : PointFlowOptions {
  constexpr PointOptionsOf() {
    if constexpr (Sensors::has_imu) {
      sigma_px = 0.1;
      sigma_residual = 3;
      if constexpr (Sensors::has_depth) min_views = 3;
    }
  }
};

template <class Store>
class PointFlow {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  using Options = PointOptionsOf<Sensors>;
  static constexpr bool votes = true;
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

  /// Gives take(index, correspondence) of every located landmark that the frame sees.
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
        correspondence.sigma_inverse_depth = std::hypot(depth.sigma, landmark.geometry.sigma_inverse_range);
      }
      take(static_cast<int>(i), correspondence);
    }
  }

  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    int searches = 0;
    // Which landmarks get searched for rotates, so that none is left out for ever.
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
      if (!inside(view, seen, border_px)) continue;
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

  /// By the frame's depth, or by parallax where there is enough, against keyframes too where one view is not believed.
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
      Views views;
      views.push_back({T_cam_anchor, ray.bearing, sigma_rad});
      if (options_.min_views > 1) add_keyframes(view, window, landmark, sigma_rad, views);
      if (static_cast<int>(views.size()) < options_.min_views) continue;
      const std::span<const TriangulationView<S>> all(views.data(), views.size());
      const Triangulation<S> found = triangulate<S>(landmark.geometry.bearing, all, options_.triangulation);
      if (!found.valid) continue;
      landmark.located = true;
      landmark.geometry.inverse_range = found.inverse_range;
      landmark.geometry.sigma_inverse_range = std::sqrt(found.variance);
    }
  }

  /// New landmarks from corners, beside those in sight; and those without depth so far, by the keyframe's. Of what is
  /// in sight the keyframe shows how its surface slants.
  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot) {
    const SE3<S> T_world_cam = window.T_world_body(slot) * view.T_body_cam, T_cam_world = T_world_cam.inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      locate_from_depth(landmark, ray.bearing, T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam));
    }
    learn_slants(view, window, store, T_cam_world);
    in_sight_.clear();
    for (const Landmark& landmark : store.landmarks()) {
      if (landmark.current.valid) in_sight_.push_back(landmark.current.pixel);
    }
    corners_.clear();
    detect_corners(view.current.level(0), in_sight_.data(), in_sight_.size(), options_.corners, corners_);
    int missing = options_.target_count - static_cast<int>(in_sight_.size());
    for (const Corner& corner : corners_) {
      if (missing <= 0) break;
      Landmark landmark;
      observe(view, landmark, true, corner.uv);
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid || !landmark.appearance.patch.capture(view.current, corner.uv)) continue;
      auto& point = landmark.geometry;
      point.bearing = ray.bearing;
      point.slope.set(view.shutter.bearing_slope(corner.uv.template cast<S>(), ray.bearing, S(0)));
      if (const InverseDepth<S>& depth = landmark.current.depth.get(); depth.valid) {
        landmark.located = true;
        point.inverse_range = depth.value * ray.bearing.z();
        point.sigma_inverse_range = depth.sigma * ray.bearing.z();
      }
      if (!store.add(landmark, slot)) break;
      --missing;
    }
  }

  /// Gives visit(bearing in the anchor, bearing now) of every landmark anchored in `slot` that the frame sees.
  void for_each_pair(const View<Sensors>& view, const Store& store, int slot, auto&& visit) const {
    for (const Landmark& landmark : store.landmarks()) {
      if (landmark.anchor != slot || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(landmark.current.uv.template cast<S>());
      if (ray.valid) visit(landmark.geometry.bearing, ray.bearing);
    }
  }

  // For front ends of one's own that follow points in another way.

  /// Where the current image should show a landmark that the previous one shows; the same place where that is nowhere.
  static Vec<float, 2> expected(const View<Sensors>& view, const auto& window, const Landmark& landmark,
                                const SE3<S>& T_cam_world) {
    Vec<S, 3> p_cam;
    S inverse_range = S(landmark.current.slope.get().inverse_range);
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

  /// The current image shows the landmark where its pixels in the anchor were found, or does not.
  void observe(const View<Sensors>& view, Landmark& landmark, const Alignment& aligned) const {
    observe(view, landmark, aligned.valid, aligned.uv);
    constexpr float least_rms = 0.25f;  // of intensities that are whole numbers
    const float sigma_intensity = float(options_.sigma_residual) * std::max(aligned.rms, least_rms);
    if (aligned.valid)
      landmark.current.L = whitening_of(aligned.information_per_intensity, float(options_.sigma_px), sigma_intensity);
  }
  /// The current image shows the landmark at `pixel`, or does not.
  void observe(const View<Sensors>& view, Landmark& landmark, bool valid, const Vec<float, 2>& pixel) const {
    typename Kind::Observation& seen = landmark.current;
    seen.valid = valid;
    if (!valid) {
      ++landmark.misses;
      return;
    }
    landmark.misses = 0;
    // As far away as a frame ago: that is near enough for the shutter.
    const StillPixel<S> still = view.shutter.still(pixel.template cast<S>(), S(seen.slope.get().inverse_range));
    seen.pixel = pixel;
    seen.uv = still.uv.template cast<float>();
    seen.slope.set(
        {cast_to<float>(still.slope.by_turn), cast_to<float>(still.slope.by_shift), float(still.slope.inverse_range)});
    seen.L = identity<float, 2>() / float(options_.sigma_flow_px);
    if constexpr (Sensors::has_depth) seen.depth.set(view.rig.vision.depth.at(view.depth, pixel));
  }

 private:
  static constexpr float border_px = 8;  ///< half an alignment patch and the interpolation's neighbour

  static bool inside(const View<Sensors>& view, const Vec<S, 2>& uv, float border) {
    return view.current.level(0).contains(float(uv.x()), float(uv.y()), border);
  }
  static Vec<S, 3> p_world(const Landmark& landmark, const auto& window, const SE3<S>& T_body_cam) {
    return window.T_world_body(landmark.anchor) * (T_body_cam * Kind::middle(landmark.geometry));
  }

  void learn_slants(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_cam_world) const {
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

  using Views = FixedVector<TriangulationView<S>, static_cast<std::size_t>(Store::slots) + 1>;
  /// Those that saw the landmark, but its anchor.
  static void add_keyframes(const View<Sensors>& view, const auto& window, const Landmark& landmark, S sigma_rad,
                            Views& views) {
    const SE3<S> T_world_anchor = window.T_world_body(landmark.anchor) * view.T_body_cam;
    for (int slot = 0; slot < Store::slots; ++slot) {
      const auto& seen = landmark.observations[static_cast<std::size_t>(slot)];
      if (slot == landmark.anchor || !seen.valid) continue;
      const Unprojection<S> ray = view.camera().unproject(seen.uv.template cast<S>());
      const SE3<S> T_cam_world = (window.T_world_body(slot) * view.T_body_cam).inverse();
      if (ray.valid) views.push_back({T_cam_world * T_world_anchor, ray.bearing, sigma_rad});
    }
  }

  /// The inverse range of a landmark from the depth measured along `bearing` in the latest frame.
  static void locate_from_depth(Landmark& landmark, const Vec<S, 3>& bearing, const SE3<S>& T_cam_anchor) {
    const InverseDepth<S>& depth = landmark.current.depth.get();
    if (!depth.valid) return;
    const Vec<S, 3> p_anchor = T_cam_anchor.inverse() * Vec<S, 3>(bearing / (depth.value * bearing.z()));
    const S range = norm(p_anchor);
    // The anchor's pixel and the depth elsewhere must tell of the same direction.
    if (!(dot(p_anchor, landmark.geometry.bearing) > S(0.999) * range)) return;
    landmark.located = true;
    landmark.geometry.inverse_range = S(1) / range;
    landmark.geometry.sigma_inverse_range = depth.sigma * bearing.z();
  }

  PointFlowOptions options_;
  FixedVector<Vec<float, 2>, Store::capacity> in_sight_;
  FixedVector<Corner, Store::capacity> corners_;
  std::size_t first_search_ = 0;
};

}  // namespace plumbline
