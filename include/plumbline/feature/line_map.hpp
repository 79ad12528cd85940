#pragma once
/// The lines of a window: straight edges found, followed from frame to frame, located and recognized again.
///                                                                                          docs/math/line.md
/// Where the predicted pose sees a line its edge is looked for; once the pose is known, lines without one are looked
/// for again, nearer. A line is known from the depth beside it, or from the planes of keyframes with parallax.
/// Duplicates are the younger of two lines on one edge.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/line_landmark.hpp"
#include "plumbline/feature/line_motion_terms.hpp"
#include "plumbline/feature/line_window_terms.hpp"
#include "plumbline/feature/make_room.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/feature/visible_segment.hpp"
#include "plumbline/geometry/line_depth.hpp"
#include "plumbline/geometry/line_triangulation.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/sensor/line_depth_measurement.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"

namespace plumbline {

struct LineOptions {
  float sigma_px = 0.4f;      ///< of an endpoint across the segment, however long and sharp the edge
  float peak_spacing_px = 4;  ///< of peaks along the edge that err independently
  int target_count = 60;      ///< segments are detected until this many landmarks are in sight
  int max_misses = 30;        ///< frames in a row that look for a landmark in vain before it is forgotten
  int min_observations = 2;   ///< keyframes that saw a landmark that is kept although it is out of sight: it ties them
  float search_again_px = 5;  ///< across the edge, once the pose is known
  LineDetectorOptions detector;
  LineTrackingOptions tracking;
  LineDepthSampling depth;
  LineTriangulationOptions triangulation;
};

template <SensorRig Sensors, int Capacity, int Slots, LineDetector Detector = LineSegmentDetector<>>
class LineMap {
 public:
  using S = typename Sensors::Scalar;
  using Options = LineOptions;
  using Landmark = LineLandmark<S, Slots>;
  using Observation = SegmentObservation<S>;
  using Window = FrameWindow<S, Slots>;
  using Landmarks = FixedVector<Landmark, Capacity>;
  template <int BlockDim>
  using WindowTerms = LineWindowTerms<Sensors, LineMap, BlockDim>;
  using MotionTerms = LineMotionTerms<Sensors, LineMap>;

  /// Of the latest frame: seen there, but not where its pose has it.
  struct Rejected {
    std::uint32_t id;
    LineSegment segment;
  };

  explicit LineMap(const Options& options) : options_(options) {}

  const Options& options() const { return options_; }
  const Landmarks& landmarks() const { return landmarks_; }
  Landmarks& landmarks() { return landmarks_; }
  const FixedVector<Rejected, Capacity>& rejected() const { return rejected_; }

  /// Located landmarks that the latest frame sees.
  int tracked_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid && landmark.located;
    return n;
  }

  /// Follows all landmarks of the previous frame into the current one, starting where the predicted pose sees them.
  void track(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body_previous,
             const SE3<S>& T_world_body_predicted) {
    rejected_.clear();
    has_edges_ = edges_.compute(view.current.level(0), options_.detector.min_gradient);
    const SE3<S> T_cam_world = (T_world_body_predicted * view.T_body_cam).inverse();
    const SO3<S> R_cam_previous = T_cam_world.rotation() * (T_world_body_previous * view.T_body_cam).rotation();
    for (Landmark& landmark : landmarks_) {
      landmark.previous = landmark.current;
      if (!landmark.current.valid) continue;
      remember_appearance(landmark);
      landmark.current.valid = false;
      LineSegment guess;
      const LineReprojection<S>& before = landmark.previous.pixels;
      const bool visible = landmark.located ? predicted_segment(view, window, landmark, T_cam_world, guess)
                                            : visible_segment(view, Vec<S, 3>(R_cam_previous * before.bearing_start),
                                                              Vec<S, 3>(R_cam_previous * before.bearing_end), guess);
      if (visible) follow(view, landmark, guess, options_.tracking);
      if (!landmark.current.valid) ++landmark.misses;
    }
    reject_duplicates();
  }

  /// Three lines give a pose, but a wrong one as easily: lines leave the search for it to others, and what does not fit
  /// to `gate`.
  void reject_outliers(const View<Sensors>&, const Window&, const auto& /*options*/, SE3<S>&) {}

  /// All errors of the frame are `scale` times those expected.
  void scale_sigma(int index, S scale) { landmarks_[static_cast<std::size_t>(index)].current.scale_sigma(scale); }
  void reject_current(int index) {
    Landmark& landmark = landmarks_[static_cast<std::size_t>(index)];
    landmark.current.valid = false;
    rejected_.push_back({landmark.id, landmark.current.segment});
  }

  /// Looks again for every landmark without an edge that the pose puts into the image, and updates what is seen of the
  /// others.
  void align(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    LineTrackingOptions near = options_.tracking;
    near.search_px = options_.search_again_px;
    for (Landmark& landmark : landmarks_) {
      if (!landmark.located) continue;
      LineSegment guess;
      if (predicted_segment(view, window, landmark, T_cam_world, guess)) {
        const Observation before = landmark.current;
        follow(view, landmark, guess, near);
        if (!landmark.current.valid && before.valid) landmark.current = before;
        if (!landmark.current.valid) ++landmark.misses;
      }
      if (!landmark.current.valid) continue;
      const LineReprojection<S>& seen = landmark.current.pixels;
      landmark.set_extent(T_cam_world * T_world_anchor(landmark, window, view.T_body_cam), seen.bearing_start,
                          seen.bearing_end);
    }
    reject_duplicates();
  }

  /// Records what the latest frame saw as observations of the frame in `slot`.
  void record(int slot) {
    for (Landmark& landmark : landmarks_) landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
  }

  /// The same for a keyframe, which becomes the anchor of lines located by its depth image and of newly found ones.
  void insert_keyframe(const View<Sensors>& view, const Window&, int slot) {
    record(slot);
    for (Landmark& landmark : landmarks_) {
      if (!landmark.located && landmark.current.valid && landmark.current.has_depth) locate_from_depth(landmark, slot);
    }
    detect(view, slot);
  }

  /// Locates lines without depth by the latest frame's view of them: its depth, or parallax where there is enough.
  void triangulate(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    for (Landmark& landmark : landmarks_) {
      const Observation& in_anchor = landmark.seen_by_anchor();
      if (landmark.located || !landmark.current.valid || !in_anchor.valid) continue;
      if (landmark.current.has_depth) {
        locate_from_depth(landmark, {window[landmark.anchor].pose.value(), T_world_body, view.T_body_cam});
      }
      if (landmark.located) continue;
      const std::array<LineTriangulationView<S>, 2> views{
          view_of(in_anchor, SE3<S>()),
          view_of(landmark.current, T_cam_world * T_world_anchor(landmark, window, view.T_body_cam))};
      const auto found = triangulate_line(std::span<const LineTriangulationView<S>>(views), options_.triangulation);
      if (found.valid) locate(landmark, found.line, found.covariance);
    }
  }

  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    for (Landmark& landmark : landmarks_) landmark.rescale(scale);
  }

  /// Forgets the keyframe in `slot` and every landmark that is anchored there.
  void remove_keyframe(int slot) {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      landmarks_[i].observations[static_cast<std::size_t>(slot)].valid = false;
      if (landmarks_[i].anchor == slot) landmarks_.swap_remove(i);
    }
  }

  /// Forgets landmarks that cannot be of use any more.
  void prune() {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      const Landmark& landmark = landmarks_[i];
      if (landmark.current.valid) continue;
      const bool unproven = !landmark.located || landmark.observation_count() < options_.min_observations;
      if (unproven || landmark.misses > options_.max_misses) landmarks_.swap_remove(i);
    }
  }

  void clear() { landmarks_.clear(); }

  /// The readout time of all images turned out to be `change_s` longer than thought.
  void change_readout(S change_s) {
    for (Landmark& landmark : landmarks_) landmark.change_readout(change_s);
  }

  /// Back to what the frame before saw, for a frame that could not be used.
  void undo_frame() {
    for (Landmark& landmark : landmarks_) landmark.current = landmark.previous;
  }

  /// Adds up how far [px] the landmarks in sight moved since the keyframe in `slot`. An edge shows its motion across it
  /// alone, which for edges of all directions is 2/pi of the whole on average.
  void add_motion_since(int slot, double& sum_px, int& count) const {
    constexpr double half_pi = 1.5707963267948966;
    for (const Landmark& landmark : landmarks_) {
      const Observation& then = landmark.observations[static_cast<std::size_t>(slot)];
      if (!landmark.current.valid || !then.valid) continue;
      const LineSegment& now = landmark.current.segment;
      sum_px += half_pi * (std::abs(now.distance(then.segment.start)) + std::abs(now.distance(then.segment.end))) / 2;
      ++count;
    }
  }

  /// Adds up the inverse ranges of the landmarks in sight, from their anchors [1/m].
  void add_inverse_ranges(S& sum, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      if (!landmark.current.valid || !landmark.located) continue;
      sum += S(1) / landmark.middle().norm();
      ++count;
    }
  }

  /// World coordinates of the middle of a located landmark.
  static Vec<S, 3> p_world(const Landmark& landmark, const Window& window, const SE3<S>& T_body_cam) {
    return T_world_anchor(landmark, window, T_body_cam) * landmark.middle();
  }

 private:
  /// Of the anchor's camera.
  static SE3<S> T_world_anchor(const Landmark& landmark, const Window& window, const SE3<S>& T_body_cam) {
    return window[landmark.anchor].pose.value() * T_body_cam;
  }

  bool predicted_segment(const View<Sensors>& view, const Window& window, const Landmark& landmark,
                         const SE3<S>& T_cam_world, LineSegment& out) const {
    const SE3<S> T_cam_anchor = T_cam_world * T_world_anchor(landmark, window, view.T_body_cam);
    return visible_segment(view, Vec<S, 3>(T_cam_anchor * landmark.at(landmark.extent[0])),
                           Vec<S, 3>(T_cam_anchor * landmark.at(landmark.extent[1])), out);
  }

  static void remember_appearance(Landmark& landmark) {
    landmark.profile = landmark.current.profile;
    landmark.gradient = landmark.current.segment.gradient;
  }

  void follow(const View<Sensors>& view, Landmark& landmark, LineSegment guess, const LineTrackingOptions& tracking) {
    guess.gradient = landmark.gradient;
    observe(view, tracker_.track(edges_, view.current.level(0), landmark.profile, guess, tracking), landmark.current);
    if (landmark.current.valid) landmark.misses = 0;
  }

  void observe(const View<Sensors>& view, const TrackedLine& tracked, Observation& out) const {
    out.valid = false;
    if (!tracked.valid) return;
    const typename Sensors::Camera& camera = view.rig.vision.camera;
    const Vec<S, 2> start = tracked.segment.start.template cast<S>(), end = tracked.segment.end.template cast<S>();
    const LineObservation<S> seen = observe_line(camera, view.shutter.still(start).uv, view.shutter.still(end).uv);
    const float peaks = std::max(1.0f, tracked.support * tracked.segment.length() / options_.peak_spacing_px);
    out.valid =
        seen.valid && out.set_pixels(seen.reprojection,
                                     endpoint_covariance(options_.sigma_px, tracked.rms_px, peaks).template cast<S>());
    if (!out.valid) return;
    out.segment = tracked.segment;
    out.profile = tracked.profile;
    out.bearing_slope << view.shutter.bearing_slope(start, seen.reprojection.bearing_start),
        view.shutter.bearing_slope(end, seen.reprojection.bearing_end);
    out.has_depth = false;
    if constexpr (Sensors::has_depth) {
      const LineDepth<S> depth = measure_line_depth(camera, view.rig.vision.depth, view.depth, tracked.segment.start,
                                                    tracked.segment.end, options_.depth);
      if (depth.valid) out.set_depth(depth.inverse_depth, depth.covariance);
    }
  }

  /// Two lines on one edge are one, the older: located ones first, then by age.
  void reject_duplicates() {
    order_.clear();
    segments_.clear();
    for (Landmark& landmark : landmarks_) {
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

  /// A line in its anchor's camera.
  static void locate(Landmark& landmark, const Line3<S>& line, const Mat<S, 4, 4>& covariance) {
    const LineReprojection<S>& seen = landmark.seen_by_anchor().pixels;
    landmark.line = line;
    landmark.covariance = covariance;
    landmark.set_extent(SE3<S>(), seen.bearing_start, seen.bearing_end);
    landmark.located = landmark.is_sound();
  }

  static LineTriangulationView<S> view_of(const Observation& seen, const SE3<S>& T_cj_ca) {
    return {T_cj_ca, seen.pixels.bearing_start, seen.pixels.bearing_end,
            std::sqrt(seen.pixels_covariance(0, 0)) * 2 / seen.pixels.px_per_rad.sum()};
  }

  /// The line from the depth measured in the keyframe in `slot`, which becomes its anchor.
  static void locate_from_depth(Landmark& landmark, int slot) {
    const Observation& seen = landmark.observations[static_cast<std::size_t>(slot)];
    const Line3<S> line = line_from_depth(seen.depth.m_start, seen.depth.m_end, seen.depth.inverse_depth_measured);
    DenseNormalEquations<double, 4> system;
    add_anchor(seen.pixels, seen.pixels_L, line, system);
    add_anchor(seen.depth, seen.depth_L, line, system);
    Mat<double, 4, 4> covariance;
    if (!system.covariance(covariance)) return;
    landmark.anchor = slot;
    locate(landmark, line, covariance.template cast<S>());
  }

  /// The line from its edge in the anchor and edge and depth in the latest frame.
  static void locate_from_depth(Landmark& landmark, const RelativeView<S>& latest) {
    const Observation &in_anchor = landmark.seen_by_anchor(), &seen = landmark.current;
    const Vec<S, 2>& inverse_depth = seen.depth.inverse_depth_measured;
    const Mat<S, 3, 3> R_anchor_latest = latest.R_target_anchor().transpose();
    const auto to_anchor = [&](const Vec<S, 3>& p) {
      return Vec<S, 3>(R_anchor_latest * (p - latest.t_target_anchor()));
    };
    Line3<S> line = Line3<S>::through(to_anchor(seen.depth.m_start / inverse_depth[0]),
                                      to_anchor(seen.depth.m_end / inverse_depth[1]));
    Mat<double, 4, 4> covariance;
    for (int iteration = 0; iteration < 3; ++iteration) {
      DenseNormalEquations<double, 4> system;
      Vec<double, 4> step;
      add_anchor(in_anchor.pixels, in_anchor.pixels_L, line, system);
      add_latest(seen.pixels, seen.pixels_L, latest, line, system);
      add_latest(seen.depth, seen.depth_L, latest, line, system);
      if (!system.solve(step) || !system.covariance(covariance)) return;
      line = line.plus(Vec<S, 4>(step.template cast<S>()));
    }
    const AnchoredLine<LineReprojection<S>> pixels{in_anchor.pixels};
    const Vec<S, 2> r = product(in_anchor.pixels_L, pixels.linearize_in_anchor(line).r);
    if (r.squaredNorm() < S(13.8)) {  // 99.9 %, as in the window
      locate(landmark, line, covariance.template cast<S>());
    }
  }

  template <class Measurement>
  static void add_anchor(const Measurement& measurement, const Mat<S, 2, 2>& L, const Line3<S>& line,
                         DenseNormalEquations<double, 4>& system) {
    const auto lin = AnchoredLine<Measurement>{measurement}.linearize_in_anchor(line);
    if (lin.valid) system.add(product(L, lin.J_r_line), product(L, lin.r), 1.0);
  }
  template <class Measurement>
  static void add_latest(const Measurement& measurement, const Mat<S, 2, 2>& L, const RelativeView<S>& latest,
                         const Line3<S>& line, DenseNormalEquations<double, 4>& system) {
    const auto lin = AnchoredLine<Measurement>{measurement}.linearize(latest, line);
    if (lin.valid) system.add(product(L, lin.J_r_lambda), product(L, lin.r), 1.0);
  }

  /// New landmarks from segments that are no part of one in sight.
  void detect(const View<Sensors>& view, int slot) {
    const ImageView<const std::uint8_t>& image = view.current.level(0);
    if (!has_edges_) has_edges_ = edges_.compute(image, options_.detector.min_gradient);
    if (!has_edges_) return;
    detector_.detect(image, edges_, options_.detector, detected_);
    has_edges_ = false;  // the detector may have taken their pixels
    segments_.clear();
    for (const Landmark& landmark : landmarks_) {
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
      landmark.id = next_id_++;
      landmark.anchor = slot;
      landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
      remember_appearance(landmark);
      if (landmark.current.has_depth) locate_from_depth(landmark, slot);
      if (!make_room(landmarks_)) break;
      landmarks_.push_back(landmark);
      segments_.push_back(landmark.current.segment);
    }
  }

  Options options_;
  Landmarks landmarks_;
  FixedVector<Rejected, Capacity> rejected_;
  EdgeMap<decltype(Sensors::vision)::max_pixels> edges_;
  bool has_edges_ = false;  ///< of the current frame, not yet taken by the detector
  LineTracker tracker_;
  Detector detector_;
  FixedVector<LineSegment, 300> detected_;
  FixedVector<LineSegment, Capacity> segments_;  ///< scratch
  FixedVector<Landmark*, Capacity> order_;
  std::array<bool, Capacity> duplicate_;
  std::uint32_t next_id_ = 0;
};

}  // namespace plumbline
