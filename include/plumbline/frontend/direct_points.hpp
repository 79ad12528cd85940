#pragma once
/// Front end of points by direct tracking: the pose of the frame comes from patches of all landmarks together
/// (frontend/image_motion.hpp), then each point is aligned with its patch in the anchor, near its projection.
///
/// Without a depth sensor the inverse depth of a new point is estimated by a depth filter; if neither feature alignment
/// nor optical flow finds it, it is searched along its epipolar curve. Landmarks out of view are searched near their
/// projections by the estimated pose. Before any landmark is located all points are tracked by optical flow.
///                                                                          docs/math/direct.md, docs/math/tracking.md

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/depth_filters.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/geometry/depth_filter.hpp"
#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/tracking/epipolar_search.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/image_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace plumbline {

template <SensorRig Sensors>
struct DirectPointOptions : PointOptionsOf<Sensors> {
  /// Largest distance between aligned and projected position [px]; tuned: docs/decisions/135 (chosen).
  float max_correction_px = 4;
  bool flow_as_well = true;  ///< use optical flow where feature alignment fails; tuned: docs/decisions/084
  /// Use depth filters for new landmarks; else triangulate from two views with enough parallax;
  /// tuned: docs/decisions/135 (chosen).
  bool filter_depth = true;
  /// Relative sigma of the inverse depth below which a new landmark is located; tuned: docs/decisions/135 (chosen).
  double max_depth_error = 0.33;
  /// Largest number of epipolar searches for new landmarks in one frame; tuned: docs/decisions/135 (chosen).
  int max_new_searches = 60;
  EpipolarSearchOptions epipolar;
};

template <class Store>
class DirectPoints {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  using Options = DirectPointOptions<Sensors>;
  static constexpr bool gives_correspondences = true;
  static constexpr bool relates_two_views = true;
  static constexpr int max_alignment_samples = Store::capacity;

  explicit DirectPoints(const Options& options) : options_(options), flow_(options) {}

  /// take(sample) for every located landmark in view of the previous image.
  void for_each_alignment_sample(const View<Sensors>& view, const auto& window, const Store& store,
                                 const SE3<S>& T_world_predicted, auto&& take) const {
    const SE3<S> T_cam_world = (T_world_predicted * view.T_body_cam).inverse();
    const SE3<S> T_previous_world = (view.T_world_previous * view.T_body_cam).inverse();
    for (const Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid || !landmark.located) continue;
      const Vec<S, 3> at = p_world(landmark, window, view.T_body_cam);
      const S range = norm(T_previous_world * at);
      const Unprojection<S> ray = view.camera().unproject(cast_to<S>(landmark.current.uv));
      const Vec<S, 3> p_cam = T_cam_world * at;
      const Projection<S> predicted = view.camera().project(p_cam);
      if (!ray.valid || !predicted.valid) continue;
      const Vec<S, 2> seen = view.shutter.seen(predicted.uv, S(1) / norm(p_cam)), shift = seen - predicted.uv;
      if (view.current.mask().excludes(cast_to<float>(seen))) continue;
      take(AlignmentSample<S>{landmark.current.pixel, cast_to<float>(shift),
                              view.T_body_cam * Vec<S, 3>(range * ray.bearing), 1});
    }
  }

  void follow(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_aligned) {
    const SE3<S> T_cam_world = (T_world_aligned * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid) continue;
      Vec<float, 2> guess = flow_.expected(view, window, landmark, T_cam_world);
      S inverse_range = landmark.geometry.inverse_range;
      bool known = landmark.located;
      if (!known) {  // a located landmark has no filter and must not replace that of another one
        const DepthFilter<S>& depth = depth_filters_.of(landmark.id);
        known = depth.known();
        if (known) {
          inverse_range = depth.mu;
          guess = moved(view, window, landmark, depth.mu, T_cam_world, guess);
        }
      }
      if (known) {
        const Alignment aligned =
            align(view, window, landmark, inverse_range, T_cam_world, guess, /*coarse_start=*/!landmark.located);
        if (aligned.valid) {
          flow_.observe(view, landmark, aligned);
          continue;
        }
        if (!options_.flow_as_well) {
          flow_.observe(view, landmark, false, guess);
          continue;
        }
      }
      const FlowResult flow =
          track_point_checked(view.previous, view.current, landmark.current.pixel, guess, options_.flow);
      flow_.observe(view, landmark, flow.valid, flow.uv);
    }
  }

  void for_each_correspondence(const View<Sensors>& view, const auto& window, const Store& store, auto&& take) const {
    flow_.for_each_correspondence(view, window, store, take);
  }

  /// Searches landmarks that are not tracked.
  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    auto& landmarks = store.landmarks();
    const std::size_t n = landmarks.size();
    int searches = 0;
    // The search begins at another landmark in every frame, so that none is left out permanently.
    for (std::size_t k = 0; k < n && searches < options_.max_searches; ++k) {
      Landmark& landmark = landmarks[(k + first_search_) % n];
      if (!landmark.located || landmark.current.valid) continue;
      Vec<float, 2> seen;
      if (!predict(view, window, landmark, T_cam_world, seen)) continue;
      ++searches;
      const Alignment aligned =
          align(view, window, landmark, landmark.geometry.inverse_range, T_cam_world, seen, /*coarse_start=*/true);
      flow_.observe(view, landmark, aligned);
    }
    if (n > 0) first_search_ = (first_search_ + static_cast<std::size_t>(options_.max_searches)) % n;
    search_new(view, window, store, T_cam_world);
  }

  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    S sum = S(0);
    int count = 0;
    store.add_inverse_ranges(sum, count);
    if (Sensors::has_depth || !options_.filter_depth || count < min_located) {
      flow_.locate(view, window, store, T_world_body);
      return;
    }
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid) continue;
      DepthFilter<S>& depth = depth_filters_.of(landmark.id);
      if (!depth.known()) depth = DepthFilter<S>::around(sum / S(count));
      measure(view, landmark, T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam), depth);
      if (depth.diverged()) landmark.current.valid = false;
      if (!depth.converged(S(options_.max_depth_error))) continue;
      landmark.located = true;
      landmark.geometry.inverse_range = depth.mu;
      landmark.geometry.sigma_inverse_range = depth.sigma();
    }
  }
  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot) {
    flow_.detect(view, window, store, slot);
  }
  void for_each_pair(const View<Sensors>& view, const Store& store, int slot, auto&& visit) const {
    flow_.for_each_pair(view, store, slot, visit);
  }

 private:
  /// geometry: half an alignment patch and the interpolation's neighbor.
  static constexpr float border_px = 8;

  static Vec<S, 3> p_world(const Landmark& landmark, const auto& window, const SE3<S>& T_body_cam) {
    return window.T_world_body(landmark.anchor) * (T_body_cam * Kind::middle(landmark.geometry));
  }
  /// Projection of a landmark into the current image; false when it is outside.
  static bool predict(const View<Sensors>& view, const auto& window, const Landmark& landmark,
                      const SE3<S>& T_cam_world, Vec<float, 2>& seen) {
    const Vec<S, 3> p_cam = T_cam_world * p_world(landmark, window, view.T_body_cam);
    const Projection<S> predicted = view.camera().project(p_cam);
    if (!predicted.valid) return false;
    seen = cast_to<float>(view.shutter.seen(predicted.uv, S(1) / norm(p_cam)));
    return view.current.level(0).contains(seen.x(), seen.y(), border_px) && !view.current.mask().excludes(seen);
  }

  /// Updates the depth filter of a landmark by the latest frame, if the parallax gives information.
  void measure(const View<Sensors>& view, const Landmark& landmark, const SE3<S>& T_cam_anchor,
               DepthFilter<S>& depth) const {
    const Unprojection<S> ray = view.camera().unproject(cast_to<S>(landmark.current.uv));
    if (!ray.valid) return;
    const S sigma_rad = S(options_.sigma_flow_px) / effective_focal_length(view.camera());
    const std::array<TriangulationView<S>, 1> views{{{T_cam_anchor, ray.bearing, sigma_rad}}};
    constexpr double no_limit = -1e9;       // numerics: below any parallax
    constexpr S max_variance_ratio = S(4);  // numerics: two sigmas of the filter, more adds no information
    TriangulationOptions any_parallax = options_.triangulation;
    any_parallax.min_significance = no_limit;
    const Triangulation<S> seen = triangulate<S>(landmark.geometry.bearing, views, any_parallax);
    if (!(seen.variance > S(0)) || !(seen.variance < max_variance_ratio * depth.variance)) return;
    if (seen.valid) {
      depth.update(seen.inverse_range, std::sqrt(seen.variance));
    } else {
      depth.miss();
    }
  }
  /// Adds the parallax by the translation, at this inverse range, to a guess from the rotation alone.
  static Vec<float, 2> moved(const View<Sensors>& view, const auto& window, const Landmark& landmark, S inverse_range,
                             const SE3<S>& T_cam_world, const Vec<float, 2>& guess) {
    const Vec<S, 3> at =
        window.T_world_body(landmark.anchor) * (view.T_body_cam * Vec<S, 3>(landmark.geometry.bearing / inverse_range));
    const SE3<S> T_world_previous = view.T_world_previous * view.T_body_cam;
    const Vec<S, 3> in_previous = T_world_previous.inverse() * at;
    const Projection<S> turned =
        view.camera().project(T_cam_world.rotation() * (T_world_previous.rotation() * in_previous));
    const Projection<S> now = view.camera().project(T_cam_world * at);
    if (!turned.valid || !now.valid) return guess;
    return guess + cast_to<float>(now.uv - turned.uv);
  }

  /// Searches landmarks that are neither located nor tracked along their epipolar curves, within two sigmas of their
  /// depth filters.
  void search_new(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_cam_world) {
    constexpr S sigmas = S(2);    // chi-square quantile 95 %, 1 degree of freedom
    constexpr S least = S(1e-3);  // of the mean; numerics: positive inverse range
    const auto seen = [&](const Vec<S, 2>& uv, S inverse_range) { return view.shutter.seen(uv, inverse_range); };
    int searches = 0;
    for (Landmark& landmark : store.landmarks()) {
      if (searches >= options_.max_new_searches) break;
      if (landmark.located || landmark.current.valid) continue;
      const DepthFilter<S>& depth = depth_filters_.of(landmark.id);
      if (!depth.known()) continue;
      ++searches;
      const S reach = sigmas * depth.sigma();
      const InverseRangeInterval<S> lambda{depth.mu, std::max(depth.mu - reach, least * depth.mu), depth.mu + reach};
      const EpipolarMatch<S> match =
          search_epipolar_curve(view.camera(), landmark.appearance.patch, landmark.geometry.bearing, lambda,
                                T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam), view.current,
                                seen, options_.epipolar, options_.alignment);
      if (match.aligned.valid) flow_.observe(view, landmark, match.aligned);
    }
  }

  /// Feature alignment of the patch in the anchor, warped by pose and inverse range, from `guess`.
  Alignment align(const View<Sensors>& view, const auto& window, const Landmark& landmark, S inverse_range,
                  const SE3<S>& T_cam_world, const Vec<float, 2>& guess, bool coarse_start) const {
    const SE3<S> T_cam_anchor = T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam);
    const auto& [patch, slant] = landmark.appearance;
    const Mat<float, 2, 2> A =
        affine_warp(view.camera(), view.camera(), landmark.geometry.bearing, S(1) / inverse_range, T_cam_anchor)
            .slanted(slant.a());
    AlignmentOptions alignment = options_.alignment;
    alignment.coarse_start = coarse_start;
    Alignment aligned = align_patch(patch, A, view.current, guess, alignment);
    aligned.valid = aligned.valid && (coarse_start || norm(aligned.uv - guess) < options_.max_correction_px);
    return aligned;
  }

  static constexpr int min_located = 10;  ///< located landmarks for a filter prior; tuned: docs/decisions/135 (chosen)

  Options options_;
  PointFlow<Store> flow_;
  DepthFilters<DepthFilter<S>, Store::capacity> depth_filters_;
  std::size_t first_search_ = 0;
};

}  // namespace plumbline
