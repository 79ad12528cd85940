#pragma once
/// The point landmarks of a window: found, tracked from frame to frame, recognized again and forgotten.
///                                                                                         docs/math/point.md
/// A landmark is followed by optical flow, then aligned with its pixels in the anchor under the warp that the estimated
/// motion predicts: flow finds it whatever the motion, the anchor's pixels keep it from sliding. Landmarks out of sight
/// stay in the map and are looked for where the estimated pose puts them.

#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/make_room.hpp"
#include "plumbline/feature/point_landmark.hpp"
#include "plumbline/feature/point_motion_terms.hpp"
#include "plumbline/feature/point_window_terms.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace plumbline {

struct PointOptions {
  double sigma_px = 0.35;       ///< of an aligned observation with all the texture one could wish
  double sigma_intensity = 15;  ///< of a pixel, correlated errors of a whole patch included
  double sigma_flow_px = 1.0;   ///< of a frame-to-frame observation
  int target_count = 180;       ///< corners are detected until this many landmarks are in sight
  int max_misses = 30;          ///< frames in a row that look for a landmark in vain before it is forgotten
  int min_observations = 2;   ///< keyframes that saw a landmark that is kept although it is out of sight: it ties them
  int max_searches = 200;     ///< landmarks out of track that one frame looks for
  float max_drift_px = 2.0f;  ///< flow and alignment with the anchor may differ by this much
  OpticalFlowOptions flow;
  AlignmentOptions alignment;
  CornerOptions corners;
  TriangulationOptions triangulation;
};

template <SensorRig Sensors, int Capacity, int Slots>
class PointMap {
 public:
  using S = typename Sensors::Scalar;
  using Options = PointOptions;
  using Landmark = PointLandmark<S, Slots>;
  using Window = FrameWindow<S, Slots>;
  using Landmarks = FixedVector<Landmark, Capacity>;
  template <int BlockDim>
  using WindowTerms = PointWindowTerms<Sensors, PointMap, BlockDim>;
  using MotionTerms = PointMotionTerms<Sensors, PointMap>;
  static constexpr bool relates_two_views = true;  ///< by for_each_pair

  /// Of the latest frame: seen there, but not where its pose has it.
  struct Rejected {
    std::uint32_t id;
    Vec<float, 2> pixel;
  };

  explicit PointMap(const Options& options) : options_(options) {}

  const Options& options() const { return options_; }
  const Landmarks& landmarks() const { return landmarks_; }
  Landmarks& landmarks() { return landmarks_; }
  const FixedVector<Rejected, Capacity>& rejected() const { return rejected_; }

  /// Landmarks with known inverse range that the latest frame sees.
  int tracked_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid && landmark.located;
    return n;
  }

  /// Follows all landmarks of the previous frame into the current one, starting where the predicted pose sees them.
  void track(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body_previous,
             const SE3<S>& T_world_body_predicted) {
    rejected_.clear();
    const SE3<S> T_cam_world = (T_world_body_predicted * view.T_body_cam).inverse();
    const SO3<S> R_cam_previous = T_cam_world.rotation() * (T_world_body_previous * view.T_body_cam).rotation();
    for (Landmark& landmark : landmarks_) {
      landmark.previous = landmark.current;
      if (!landmark.current.valid) continue;
      const Vec<float, 2> pixel = landmark.current.pixel;
      Vec<S, 3> p_cam;
      if (landmark.located) {
        p_cam = T_cam_world * p_world(landmark, window, view.T_body_cam);
      } else {
        p_cam = R_cam_previous * view.rig.vision.camera.unproject(landmark.current.uv.template cast<S>()).bearing;
      }
      const Projection<S> predicted = view.rig.vision.camera.project(p_cam);
      Vec<float, 2> guess = pixel;
      if (predicted.valid) {
        const Vec<S, 2> seen = view.shutter.seen(predicted.uv);
        if (inside(view, seen, 0)) guess = seen.template cast<float>();
      }
      const FlowResult flow = track_point_checked(view.previous, view.current, pixel, guess, options_.flow);
      observe(view, landmark, flow.valid, flow.uv);
    }
  }

  /// Finds the pose most located landmarks agree on, beginning with `T_world_body`, and takes the others out of the
  /// frame. Leaves the pose alone when none is found.
  void reject_outliers(const View<Sensors>& view, const Window& window, const PoseRansacOptions& options,
                       SE3<S>& T_world_body) {
    correspondences_.clear();
    indices_.clear();
    const typename Sensors::Camera& camera = view.rig.vision.camera;
    const S sigma_rad = S(options_.sigma_flow_px) / effective_focal_length(camera);
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      const Landmark& landmark = landmarks_[i];
      if (!landmark.current.valid || !landmark.located) continue;
      const Unprojection<S> ray = camera.unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      PoseCorrespondence<S> correspondence{ray.bearing, p_world(landmark, window, view.T_body_cam), sigma_rad};
      if (const InverseDepth<S>& depth = landmark.current.depth; depth.valid) {
        correspondence.inverse_depth = depth.value;
        correspondence.sigma_inverse_depth = std::hypot(depth.sigma, landmark.sigma_inverse_range);
      }
      correspondences_.push_back(correspondence);
      indices_.push_back(i);
    }
    const auto found = ransac_pose(correspondences_, (T_world_body * view.T_body_cam).inverse(), options);
    if (!found.valid) return;
    T_world_body = (view.T_body_cam * found.T_cam_world).inverse();
    for (std::size_t k = 0; k < indices_.size(); ++k) {
      if (!found.inlier[k]) reject_current(static_cast<int>(indices_[k]));
    }
  }

  /// All errors of the frame are `scale` times those expected.
  void scale_sigma(int index, float scale) { landmarks_[static_cast<std::size_t>(index)].current.L /= scale; }
  void reject_current(int index) {
    Landmark& landmark = landmarks_[static_cast<std::size_t>(index)];
    landmark.current.valid = false;
    rejected_.push_back({landmark.id, landmark.current.pixel});
  }

  /// Aligns every landmark that the pose puts into the image with its pixels in the anchor: tracked ones are corrected,
  /// lost ones found again.
  void align(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body) {
    const SE3<S> T_world_cam = T_world_body * view.T_body_cam;
    const SE3<S> T_cam_world = T_world_cam.inverse();
    int searches = 0;
    // Which landmarks get searched for rotates, so that none is left out for ever.
    const std::size_t n = landmarks_.size();
    for (std::size_t k = 0; k < n; ++k) {
      Landmark& landmark = landmarks_[(k + first_search_) % n];
      if (!landmark.located) continue;
      const bool tracked = landmark.current.valid;
      if (!tracked && searches >= options_.max_searches) continue;
      const SE3<S> T_cam_anchor = T_cam_world * (window[landmark.anchor].pose.value() * view.T_body_cam);
      const Projection<S> predicted = view.rig.vision.camera.project(T_cam_anchor * landmark.p_anchor_cam());
      if (!predicted.valid) continue;
      const Vec<S, 2> seen = view.shutter.seen(predicted.uv);
      if (!inside(view, seen, border_px)) continue;
      if (!tracked) ++searches;
      const typename Sensors::Camera& camera = view.rig.vision.camera;
      const Mat<float, 2, 2> A =
          affine_warp(camera, camera, landmark.bearing, S(1) / landmark.inverse_range, T_cam_anchor);
      const Vec<float, 2> start = tracked ? landmark.current.pixel : seen.template cast<float>();
      AlignmentOptions alignment = options_.alignment;
      alignment.coarse_start = !tracked;
      const Alignment aligned = align_patch(landmark.patch, A, view.current, start, alignment);
      if (tracked) {
        if (!aligned.valid || !((aligned.uv - start).norm() < options_.max_drift_px)) continue;
      }
      observe(view, landmark, aligned.valid, aligned.uv);
      if (aligned.valid) {
        landmark.current.L =
            whitening_of(aligned.information_per_intensity, float(options_.sigma_px), float(options_.sigma_intensity));
      }
    }
    if (n > 0) first_search_ = (first_search_ + static_cast<std::size_t>(options_.max_searches)) % n;
  }

  /// Records what the latest frame saw as observations of the frame in `slot`.
  void record(int slot) {
    for (Landmark& landmark : landmarks_) landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
  }

  /// The same for a keyframe, which becomes the anchor of landmarks made from newly found corners.
  void insert_keyframe(const View<Sensors>& view, const Window& window, int slot) {
    record(slot);
    for (Landmark& landmark : landmarks_) {
      if (!landmark.located && landmark.current.valid) {
        locate_from_depth(view, window, landmark, window[slot].pose.value());
      }
    }
    detect(view, slot);
  }

  /// Locates landmarks without depth by the latest frame's view of them: its depth, or parallax where there is enough.
  void triangulate(const View<Sensors>& view, const Window& window, const SE3<S>& T_world_body) {
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    const S sigma_rad = S(options_.sigma_flow_px) / effective_focal_length(view.rig.vision.camera);
    for (Landmark& landmark : landmarks_) {
      if (landmark.located || !landmark.current.valid) continue;
      locate_from_depth(view, window, landmark, T_world_body);
      if (landmark.located) continue;
      const Unprojection<S> ray = view.rig.vision.camera.unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid) continue;
      const std::array<TriangulationView<S>, 1> views{
          {{T_cam_world * (window[landmark.anchor].pose.value() * view.T_body_cam), ray.bearing, sigma_rad}}};
      locate(landmark, plumbline::triangulate<S>(landmark.bearing, views, options_.triangulation));
    }
  }

  /// Gives visit(bearing in the anchor, bearing now) of every landmark anchored in `slot` that the latest frame sees.
  void for_each_pair(const View<Sensors>& view, int slot, auto&& visit) const {
    for (const Landmark& landmark : landmarks_) {
      if (landmark.anchor != slot || !landmark.current.valid) continue;
      const Unprojection<S> ray = view.rig.vision.camera.unproject(landmark.current.uv.template cast<S>());
      if (ray.valid) visit(landmark.bearing, ray.bearing);
    }
  }

  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    for (Landmark& landmark : landmarks_) {
      landmark.inverse_range /= scale;
      landmark.sigma_inverse_range /= scale;
    }
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
    const auto shift = [change_s](PointObservation<S>& seen) { seen.uv += float(change_s) * seen.uv_slope; };
    for (Landmark& landmark : landmarks_) {
      landmark.bearing = (landmark.bearing + change_s * landmark.bearing_slope).normalized();
      shift(landmark.current);
      for (PointObservation<S>& seen : landmark.observations) shift(seen);
    }
  }

  /// Back to what the frame before saw, for a frame that could not be used.
  void undo_frame() {
    for (Landmark& landmark : landmarks_) landmark.current = landmark.previous;
  }

  /// Adds up how far [px] the landmarks in sight moved since the keyframe in `slot`.
  void add_motion_since(int slot, double& sum_px, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      const PointObservation<S>& then = landmark.observations[static_cast<std::size_t>(slot)];
      if (!landmark.current.valid || !then.valid) continue;
      sum_px += (landmark.current.pixel - then.pixel).norm();
      ++count;
    }
  }

  /// Adds up the inverse ranges of the landmarks in sight, from their anchors [1/m].
  void add_inverse_ranges(S& sum, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      if (!landmark.current.valid || !landmark.located) continue;
      sum += landmark.inverse_range;
      ++count;
    }
  }

  /// World coordinates of a located landmark.
  static Vec<S, 3> p_world(const Landmark& landmark, const Window& window, const SE3<S>& T_body_cam) {
    return window[landmark.anchor].pose.value() * (T_body_cam * landmark.p_anchor_cam());
  }

 private:
  static constexpr float border_px = 8;  ///< half an alignment patch and the interpolation's neighbour

  static bool inside(const View<Sensors>& view, const Vec<S, 2>& uv, float border) {
    return view.current.level(0).contains(float(uv.x()), float(uv.y()), border);
  }

  void observe(const View<Sensors>& view, Landmark& landmark, bool valid, const Vec<float, 2>& pixel) {
    landmark.current.valid = valid;
    if (!valid) {
      ++landmark.misses;
      return;
    }
    landmark.misses = 0;
    const typename RollingShutter<typename Sensors::Camera>::Still still = view.shutter.still(pixel.template cast<S>());
    landmark.current.pixel = pixel;
    landmark.current.uv = still.uv.template cast<float>();
    landmark.current.uv_slope = still.uv_slope.template cast<float>();
    landmark.current.L = Mat<float, 2, 2>::Identity() / float(options_.sigma_flow_px);
    if constexpr (Sensors::has_depth) landmark.current.depth = view.rig.vision.depth.at(view.depth, pixel);
  }

  static void locate(Landmark& landmark, const Triangulation<S>& found) {
    if (!found.valid) return;
    landmark.located = true;
    landmark.inverse_range = found.inverse_range;
    landmark.sigma_inverse_range = std::sqrt(found.variance);
  }

  /// The inverse range of a landmark from the depth measured in the latest frame.
  static void locate_from_depth(const View<Sensors>& view, const Window& window, Landmark& landmark,
                                const SE3<S>& T_world_body) {
    const InverseDepth<S>& depth = landmark.current.depth;
    if (!depth.valid) return;
    const Unprojection<S> ray = view.rig.vision.camera.unproject(landmark.current.uv.template cast<S>());
    if (!ray.valid) return;
    const SE3<S> T_anchor_cam =
        (window[landmark.anchor].pose.value() * view.T_body_cam).inverse() * (T_world_body * view.T_body_cam);
    const Vec<S, 3> p_cam = ray.bearing / (depth.value * ray.bearing.z());
    const Vec<S, 3> p_anchor = T_anchor_cam * p_cam;
    const S range = p_anchor.norm();
    // The anchor's pixel and the depth elsewhere must tell of the same direction.
    if (!(p_anchor.dot(landmark.bearing) > S(0.999) * range)) return;
    landmark.located = true;
    landmark.inverse_range = S(1) / range;
    landmark.sigma_inverse_range = depth.sigma * ray.bearing.z();
  }

  void detect(const View<Sensors>& view, int slot) {
    FixedVector<Vec<float, 2>, Capacity> in_sight;
    for (const Landmark& landmark : landmarks_) {
      if (landmark.current.valid) in_sight.push_back(landmark.current.pixel);
    }
    corners_.clear();
    detect_corners(view.current.level(0), in_sight.data(), in_sight.size(), options_.corners, corners_);
    int missing = options_.target_count - static_cast<int>(in_sight.size());
    for (const Corner& corner : corners_) {
      if (missing <= 0 || !make_room(landmarks_)) break;
      Landmark landmark;
      observe(view, landmark, true, corner.uv);
      const Unprojection<S> ray = view.rig.vision.camera.unproject(landmark.current.uv.template cast<S>());
      if (!ray.valid || !landmark.patch.capture(view.current, corner.uv)) continue;
      landmark.id = next_id_++;
      landmark.anchor = slot;
      landmark.bearing = ray.bearing;
      landmark.bearing_slope = view.shutter.bearing_slope(corner.uv.template cast<S>(), ray.bearing);
      landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
      if (landmark.current.depth.valid) {
        landmark.located = true;
        landmark.inverse_range = landmark.current.depth.value * ray.bearing.z();
        landmark.sigma_inverse_range = landmark.current.depth.sigma * ray.bearing.z();
      }
      landmarks_.push_back(landmark);
      --missing;
    }
  }

  Options options_;
  Landmarks landmarks_;
  FixedVector<Rejected, Capacity> rejected_;
  FixedVector<Corner, Capacity> corners_;
  FixedVector<PoseCorrespondence<S>, Capacity> correspondences_;
  FixedVector<std::size_t, Capacity> indices_;
  std::size_t first_search_ = 0;
  std::uint32_t next_id_ = 0;
};

}  // namespace plumbline
