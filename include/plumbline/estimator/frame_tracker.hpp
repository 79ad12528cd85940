#pragma once
/// Tracking of one frame: its image next to the previous one, the features in it, and the pose that they give.
///
///   follow       every landmark from the previous image, then RANSAC for the pose of the frame
///   find_pose    Gauss-Newton over the inliers, without outliers, and with features located again from that pose
/// It owns the images and the front ends. Landmarks and the poses of their anchors are those of the keyframe window.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/shutter_motion.hpp"
#include "plumbline/feature/pose_refinement.hpp"
#include "plumbline/feature/row_ranges.hpp"
#include "plumbline/frontend/image_pair.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class Parts>
class FrameTracker {
 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Propagation = typename Parts::Propagation;
  using Landmarks = typename Parts::Landmarks;
  using Window = typename Parts::Window;
  using FrontEnds = typename Parts::FrontEnds;
  using Predicted = Prediction<typename Propagation::State, S>;
  using Refinement = PoseRefinement<Sensors, Landmarks>;
  using Covariance = typename Refinement::Covariance;

  explicit FrameTracker(const EstimatorOptions<Parts>& options)
      : images_(options.rotation),
        front_ends_(options),
        refinement_(options.pose),
        ransac_(options.ransac),
        min_landmarks_(options.recovery.min_landmarks),
        gap_s_(options.recovery.gap_s) {}

  ImagePair<Sensors>& images() { return images_; }
  const ImagePair<Sensors>& images() const { return images_; }
  FrontEnds& front_ends() { return front_ends_; }

  /// Time since the last frame with a usable image, or at rest [s].
  double outage_s(TimeNs t_ns) const { return seconds_between(last_usable_ns_, t_ns); }
  /// Whether the outage is so long that the rotation of the camera is unknown.
  bool is_after_gap(TimeNs t_ns) const { return outage_s(t_ns) > gap_s_; }
  void set_usable(TimeNs t_ns) { last_usable_ns_ = t_ns; }

  /// Tracks all features from the previous image and sets T to the RANSAC consensus; returns the reason of a failure.
  /// Without an IMU, after a gap, a few inliers are no consensus: they may agree by chance.
  HealthReason follow(const View<Sensors>& view, const Predicted& predicted, const Propagation& propagation,
                      const Window& window, Landmarks& landmarks, SE3<S>& T) {
    front_ends_.follow(view, window, landmarks, T);
    const auto [candidates, inliers] = front_ends_.find_consensus(
        view, window, landmarks, ransac_, T, [&](const SE3<S>& x) { return propagation.passes_gate(predicted, x); });
    const bool few = inliers < min_landmarks_ && 2 * inliers < candidates;
    return !Propagation::has_imu_factors && is_after_gap(view.t_ns) && few ? HealthReason::few_inliers
                                                                           : HealthReason::none;
  }

  /// Estimates the pose: once with all features, once without outliers, once with the features located again from that
  /// pose. Returns the reason of a failure. `keyframe` is the slot of the last keyframe, or -1 when the previous frame
  /// was none; `readout_s` the readout time of the shutter.
  HealthReason find_pose(View<Sensors>& view, const Predicted& predicted, const Propagation& propagation,
                         const Window& window, Landmarks& landmarks, int keyframe, S readout_s, SE3<S>& T,
                         Covariance& covariance) {
    const auto refine = [&] {
      return refinement_.refine(view.rig, view.T_body_cam, landmarks, window, predicted.state.T_world_body,
                                predicted.prior, T, covariance);
    };
    HealthReason failure = refine();
    const bool moves_shutter = !propagation.is_initialized() && !is_after_gap(view.t_ns);
    if (failure == HealthReason::none) {
      if (moves_shutter) update_frame_motion(view, propagation, landmarks, predicted.state, T, readout_s);
      failure = refine();
    }
    if (failure == HealthReason::none) {
      front_ends_.refine(view, window, landmarks, T);
      failure = refine();
    }
    if (failure != HealthReason::none) return failure;
    if (propagation.contradicts(predicted, T)) return HealthReason::imu_disagrees;
    if (moves_shutter && keyframe >= 0)
      update_keyframe_motion(view, propagation, landmarks, keyframe, predicted.state, T, readout_s);
    set_ranges(landmarks, window, view, T, readout_s, /*all=*/false);
    return HealthReason::none;
  }
  /// Covariance of the frame's position by its features, scaled by their residuals.  docs/math/initialization.md (7b)
  Mat<S, 3, 3> position_noise(const Covariance& covariance) const {
    return refinement_.noise_scale2() * block<3, 3>(covariance, 3, 3);
  }

  /// Detects landmarks in the keyframe of that slot.
  void detect(const View<Sensors>& view, const Window& window, Landmarks& landmarks, int slot, S readout_s) {
    front_ends_.detect(view, window, landmarks, slot);
    set_ranges(landmarks, window, view, window.T_world_body(slot), readout_s, /*all=*/true);
  }
  /// Estimates the depth of landmarks that have none yet, from the latest frame.
  void locate(const View<Sensors>& view, const Window& window, Landmarks& landmarks) {
    front_ends_.locate(view, window, landmarks, window.latest().T_world_body);
  }

 private:
  ImagePair<Sensors> images_;
  FrontEnds front_ends_;
  Refinement refinement_;
  PoseRansacOptions ransac_;
  int min_landmarks_;
  double gap_s_;
  TimeNs last_usable_ns_ = 0;
};

}  // namespace plumbline
