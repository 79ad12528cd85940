#pragma once
/// Front end of lines by direct tracking: patches along the segments take part in the image alignment of the frame
/// (frontend/image_motion.hpp); then each line is found by its edge near its projection. Without a depth sensor the
/// inverse ranges of both ends of a new line are estimated by depth filters.     docs/math/direct.md, docs/math/line.md

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/depth_filters.hpp"
#include "plumbline/frontend/edge_following.hpp"
#include "plumbline/frontend/line_location.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/geometry/segment_depth_filter.hpp"
#include "plumbline/tracking/image_alignment.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

struct DirectLineOptions : EdgeFollowingOptions {
  DirectLineOptions() {
    search_first_px = 4;           // the aligned pose is nearly the estimated one; tuned: docs/decisions/084
    search_tracked_again = false;  // tuned: docs/decisions/136 (chosen)
  }
  float sample_spacing_px = 20;  ///< distance of patches along a segment [px]; tuned: docs/decisions/136 (chosen)
  /// Largest weight of all patches of a segment together, relative to one patch of a point;
  /// tuned: docs/decisions/136 (chosen).
  float max_weight = 1.5f;
  /// Use depth filters for new landmarks; else triangulate from two views with enough parallax;
  /// tuned: docs/decisions/059.
  bool filter_depth = true;
  /// Relative sigma of the inverse range below which a new landmark is located; tuned: docs/decisions/136 (chosen).
  double max_depth_error = 0.33;
};

template <class Store, LineDetector Detector = LineSegmentDetector<>>
class DirectLines {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  using Options = LineOptionsOf<DirectLineOptions, Sensors>;
  static constexpr bool gives_correspondences = false;
  /// tuned: docs/decisions/084.
  static constexpr int max_samples_of_one = 5, max_alignment_samples = max_samples_of_one * Store::capacity;

  explicit DirectLines(const Options& options) : options_(options), edges_(options) {}

  /// take(sample) for patches along every located landmark in view of the previous image: points of the line on rays
  /// between those of its ends.
  void for_each_alignment_sample(const View<Sensors>& view, const auto& window, const Store& store,
                                 const SE3<S>& T_world_predicted, auto&& take) const {
    const SE3<S> T_cam_previous =
        (T_world_predicted * view.T_body_cam).inverse() * view.T_world_previous * view.T_body_cam;
    const SE3<S> T_previous_world = (view.T_world_previous * view.T_body_cam).inverse();
    for (const Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid || !landmark.located) continue;
      const Plucker<S> line = (T_previous_world * (window.T_world_body(landmark.anchor) * view.T_body_cam)) *
                              landmark.geometry.line.plucker();
      const LineSegment& segment = landmark.current.segment;
      const LineReprojection<S>& seen = landmark.current.pixels.measured;
      const int n = std::clamp(int(segment.length() / options_.sample_spacing_px), 2, max_samples_of_one);
      const float weight = std::min(1.0f, options_.max_weight / float(n));
      for (int k = 0; k < n; ++k) {
        const S along = (S(k) + S(0.5)) / S(n);
        const Vec<S, 3> ray = normalized(seen.bearing_start + along * (seen.bearing_end - seen.bearing_start));
        const Projection<S> before = view.camera().project(ray);
        if (!before.valid) continue;
        const Vec<S, 3> p = line.point_along(ray);
        if (!(p.z() > min_depth) || !(norm(p) < max_range)) continue;
        const Vec<float, 2> pixel = cast_to<float>(view.shutter.seen(before.uv, S(1) / norm(p)));
        const Vec<S, 3> p_cam = T_cam_previous * p;
        const Projection<S> predicted = view.camera().project(p_cam);
        if (!predicted.valid) continue;
        const Vec<S, 2> now = view.shutter.seen(predicted.uv, S(1) / norm(p_cam)), shift = now - predicted.uv;
        if (view.current.mask().excludes(cast_to<float>(now))) continue;
        take(AlignmentSample<S>{pixel, cast_to<float>(shift), view.T_body_cam * p, weight});
      }
    }
  }

  void follow(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_aligned) {
    edges_.follow(view, window, store, T_world_aligned);
  }
  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    edges_.refine(view, window, store, T_world_body);
  }
  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    S sum = S(0);
    int count = 0;
    store.add_inverse_ranges(sum, count);
    if (Sensors::has_depth || !options_.filter_depth || count < min_located) {
      edges_.locate(view, window, store, T_world_body);
      return;
    }
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid || !landmark.seen_by_anchor().valid) continue;
      SegmentDepthFilter<S>& depth = depth_filters_.of(landmark.id);
      if (!depth.known()) depth = SegmentDepthFilter<S>::around(sum / S(count));
      const SegmentRays<S> in_anchor = rays_of(landmark.seen_by_anchor().pixels);
      depth.update(in_anchor, rays_of(landmark.current.pixels),
                   T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam));
      if (depth.diverged()) landmark.current.valid = false;
      if (depth.converged(S(options_.max_depth_error), in_anchor)) locate_from_ends(landmark, depth);
    }
  }
  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot) {
    edges_.detect(view, window, store, slot);
  }

 private:
  static constexpr S min_depth = S(0.1), max_range = S(1e3);  ///< [m]; geometry: no parallax beyond
  /// Located landmarks needed for the prior of a depth filter; tuned: docs/decisions/136 (chosen).
  static constexpr int min_located = 5;

  Options options_;
  EdgeFollowing<Store, Detector> edges_;
  DepthFilters<SegmentDepthFilter<S>, Store::capacity> depth_filters_;
};

}  // namespace plumbline
