#pragma once
/// Front end of lines by tracking their edges: an edge is searched near the projection by the predicted pose, and
/// again, within a smaller distance, near that by the estimated pose. A line is located from measured depth beside it,
/// or from the planes of keyframes with parallax. Of two lines on one edge the older one is kept.     docs/math/line.md
///
/// Lines give no correspondences to the RANSAC of the pose: three of them give a pose, but wrong associations are too
/// frequent. Outliers are rejected by the gate of pose refinement.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/line_location.hpp"
#include "plumbline/frontend/segment_measurement.hpp"
#include "plumbline/frontend/visible_segment.hpp"
#include "plumbline/sensor/line_depth_measurement.hpp"
#include "plumbline/tracking/edge_gradients.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"

namespace plumbline {

struct EdgeFollowingOptions {
  /// Sigma of an endpoint normal to the segment that the length of the edge does not reduce [px];
  /// tuned: docs/decisions/042.
  float sigma_px = 0.4f;
  /// Distance of edge points with independent errors [px]; geometry: closer peaks share pixels.
  float peak_spacing_px = 4;
  /// New lines are added until this many landmarks are in view; tuned: docs/decisions/136 (chosen).
  int target_count = 60;
  /// Distance of a first search normal to the edge [px]; if it fails, or is not smaller, `tracking.search_px` is used;
  /// numerics: larger than any search range.
  float search_first_px = 1e3f;
  /// Search distance normal to the edge when the pose is estimated [px]; tuned: docs/decisions/136 (chosen).
  float search_again_px = 5;
  /// Search all lines again when the pose is estimated; else only those not found; tuned: docs/decisions/136 (chosen).
  bool search_tracked_again = true;
  LineDetectorOptions detector;
  LineTrackingOptions tracking;
  LineDepthSampling depth;
  LineTriangulationOptions triangulation;
};

/// Options `Base` with the defaults of a rig. With measured depth the sigma of endpoints is smaller: lines are then
/// located by depth, independent of the observations that are residuals.
template <class Base, SensorRig Sensors>
struct LineOptionsOf : Base {
  constexpr LineOptionsOf() {
    if constexpr (Sensors::has_depth) this->sigma_px = 0.2f;  // tuned: docs/decisions/042
  }
};

template <class Store, LineDetector Detector = LineSegmentDetector<>>
class EdgeFollowing {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  using Observation = typename Kind::Observation;
  using Options = LineOptionsOf<EdgeFollowingOptions, Sensors>;
  static constexpr bool gives_correspondences = false;

  explicit EdgeFollowing(const EdgeFollowingOptions& options) : options_(options) {}

  void follow(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_predicted) {
    const SE3<S> T_cam_world = (T_world_predicted * view.T_body_cam).inverse();
    const SO3<S> R_cam_previous = T_cam_world.rotation() * (view.T_world_previous * view.T_body_cam).rotation();
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.current.valid) continue;
      save_appearance(landmark);
      landmark.current.valid = false;
      LineSegment guess;
      const LineReprojection<S>& before = landmark.previous.pixels.measured;
      const auto derivatives = landmark.previous.derivatives.get();
      const auto ray = [&](const Vec<S, 3>& bearing, std::size_t end) {  // at the last known range
        const S lambda = derivatives[end].inverse_range;
        return lambda > S(0) ? Vec<S, 3>(bearing / lambda) : bearing;
      };
      const bool visible = landmark.located ? predicted_segment(view, window, landmark, T_cam_world, guess)
                                            : visible_segment(view, R_cam_previous * ray(before.bearing_start, 0),
                                                              R_cam_previous * ray(before.bearing_end, 1), guess);
      if (visible) {
        const bool near_first = options_.search_first_px < options_.tracking.search_px;
        if (near_first) search_edge(view, landmark, guess, within(options_.search_first_px));
        if (!landmark.current.valid) search_edge(view, landmark, guess, options_.tracking);
      }
      if (!landmark.current.valid) ++landmark.misses;
    }
    drop_duplicates(store);
  }

  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    const LineTrackingOptions near = within(options_.search_again_px);
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.located) continue;
      LineSegment guess;
      const bool search = options_.search_tracked_again || !landmark.current.valid;
      if (search && predicted_segment(view, window, landmark, T_cam_world, guess)) {
        const Observation before = landmark.current;
        search_edge(view, landmark, guess, near);
        if (!landmark.current.valid && before.valid) landmark.current = before;
        if (!landmark.current.valid) ++landmark.misses;
      }
      if (!landmark.current.valid) continue;
      const LineReprojection<S>& seen = landmark.current.pixels.measured;
      landmark.geometry.set_extent(T_cam_world * T_world_anchor(landmark, window, view.T_body_cam), seen.bearing_start,
                                   seen.bearing_end);
    }
    drop_duplicates(store);
  }

  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.located || !landmark.current.valid || !landmark.seen_by_anchor().valid) continue;
      const SE3<S> T_world_anchor_body = window.T_world_body(landmark.anchor);
      locate_line(landmark, {T_world_anchor_body, T_world_body, view.T_body_cam}, options_.triangulation,
                  (T_world_body * view.T_body_cam).inverse() * (T_world_anchor_body * view.T_body_cam));
    }
  }

  /// Adds new landmarks from detected segments that do not belong to a landmark in view. The keyframe becomes the
  /// anchor of lines that its depth locates.
  void detect(const View<Sensors>& view, const auto& /*window*/, Store& store, int slot) {
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.located && landmark.current.valid && landmark.current.has_depth()) locate_in_frame(landmark, slot);
    }
    const ImageView<const std::uint8_t>& image = view.current.level(0);
    if (!edges_.compute(image, options_.detector.min_gradient, view.current.mask())) return;
    detector_.detect(image, edges_, options_.detector, detected_);
    segments_.clear();
    for (const Landmark& landmark : store.landmarks()) {
      if (landmark.current.valid) segments_.push_back(landmark.current.segment);
    }
    for (const LineSegment& segment : detected_) {
      if (static_cast<int>(segments_.size()) >= options_.target_count) break;
      const auto is_known = [&](const LineSegment& known) { return are_one(segment, known, options_.detector.merge); };
      if (std::any_of(segments_.begin(), segments_.end(), is_known)) continue;
      Landmark landmark;
      observe(view, tracker_.track(edges_, image, profile_of(image, segment), segment, options_.tracking),
              landmark.current);
      if (!landmark.current.valid) continue;
      landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
      save_appearance(landmark);
      if (landmark.current.has_depth()) locate_in_frame(landmark, slot);
      if (!store.add(landmark, slot)) break;
      segments_.push_back(landmark.current.segment);
    }
  }

 private:
  /// Pose of the anchor's camera.
  static SE3<S> T_world_anchor(const Landmark& landmark, const auto& window, const SE3<S>& T_body_cam) {
    return window.T_world_body(landmark.anchor) * T_body_cam;
  }

  /// Projection of the extent of a located line; false when it is outside the image.
  static bool predicted_segment(const View<Sensors>& view, const auto& window, const Landmark& landmark,
                                const SE3<S>& T_cam_world, LineSegment& out) {
    const SE3<S> T_cam_anchor = T_cam_world * T_world_anchor(landmark, window, view.T_body_cam);
    const auto& line = landmark.geometry;
    return visible_segment(view, Vec<S, 3>(T_cam_anchor * line.at(line.extent[0])),
                           Vec<S, 3>(T_cam_anchor * line.at(line.extent[1])), out);
  }

  LineTrackingOptions within(float search_px) const {
    LineTrackingOptions out = options_.tracking;
    out.search_px = search_px;
    return out;
  }

  static void save_appearance(Landmark& landmark) {
    landmark.appearance = {landmark.current.profile, landmark.current.segment.gradient};
  }

  /// Searches the edge of a landmark near `guess`.
  void search_edge(const View<Sensors>& view, Landmark& landmark, LineSegment guess,
                   const LineTrackingOptions& tracking) {
    guess.gradient = landmark.appearance.gradient;
    const ImageView<const std::uint8_t>& image = view.current.level(0);
    observe(
        view,
        tracker_.track(EdgeGradients(image, view.current.mask()), image, landmark.appearance.profile, guess, tracking),
        landmark.current);
    if (landmark.current.valid) landmark.misses = 0;
  }

  /// The observation by a tracked edge, with measured depth.
  void observe(const View<Sensors>& view, const TrackedLine& tracked, Observation& out) const {
    out.valid = false;
    if (!tracked.valid) return;
    const float peaks = std::max(1.0f, tracked.support * tracked.segment.length() / options_.peak_spacing_px);
    measure_segment(view, tracked.segment, endpoint_covariance(options_.sigma_px, tracked.rms_px, peaks), out);
    if (!out.valid) return;
    out.profile = tracked.profile;
    out.clear_depth();
    if constexpr (Sensors::has_depth) {
      const LineDepth<S> depth = measure_line_depth(view.camera(), view.rig.vision.depth, view.depth,
                                                    tracked.segment.start, tracked.segment.end, options_.depth);
      if (depth.valid) out.set_depth(depth.inverse_depth, depth.covariance);
    }
  }

  /// Of several lines on one edge keeps the observation of one: a located one first, then the oldest.
  void drop_duplicates(Store& store) {
    order_.clear();
    segments_.clear();
    for (Landmark& landmark : store.landmarks()) {
      if (landmark.current.valid) order_.push_back(&landmark);
    }
    std::sort(order_.begin(), order_.end(), [](const Landmark* a, const Landmark* b) {
      return a->located != b->located ? a->located : a->id < b->id;
    });
    for (const Landmark* landmark : order_) segments_.push_back(landmark->current.segment);
    mark_duplicates(segments_, duplicate_);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      if (duplicate_[i]) order_[i]->current.valid = false;
    }
  }

  EdgeFollowingOptions options_;
  EdgeMap<decltype(Sensors::vision)::max_pixels> edges_;  ///< of the latest keyframe
  LineTracker tracker_;
  Detector detector_;
  FixedVector<LineSegment, 300> detected_;
  FixedVector<LineSegment, Store::capacity> segments_;  ///< scratch
  FixedVector<Landmark*, Store::capacity> order_;
  std::array<bool, Store::capacity> duplicate_;
};

}  // namespace plumbline
