#pragma once
/// The per-frame pipeline once there is a map: prediction, tracking, pose estimation, keyframe, publication. It owns
/// the components of an estimator, except those of the initialization.

#include <type_traits>
#include <utility>

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/shutter_motion.hpp"
#include "plumbline/feature/pose_refinement.hpp"
#include "plumbline/feature/row_ranges.hpp"
#include "plumbline/frontend/image_pair.hpp"
#include "plumbline/state/rig_state.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

template <class Parts, class MapT>
class Odometry {
 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Motion = typename Parts::Motion;
  using State = typename Motion::State;
  using Predicted = Prediction<State, S>;
  using Landmarks = typename Parts::Landmarks;
  using Backend = typename Parts::Backend;
  using Window = typename Parts::Window;
  using Options = EstimatorOptions<Parts>;
  using Pose = PoseRefinement<Sensors, Landmarks>;
  using Covariance = typename Pose::Covariance;

  Odometry(const Sensors& sensors, const Options& opts)
      : rig(sensors),
        options(opts),
        rig_state(sensors, opts.readout),
        images(opts.rotation),
        landmarks(Parts::FrontEnds::make_landmarks(opts)),
        front_ends(opts),
        motion(sensors, opts.motion),
        backend(opts.backend, opts.motion),
        world_uncertainty(S(opts.calibration_error), Sensors::has_imu),
        pose_(opts.pose),
        rule_(opts.keyframe) {}

  const Sensors rig;
  const Options options;
  RigState<Sensors> rig_state;
  ImagePair<Sensors> images;
  Landmarks landmarks;
  typename Parts::FrontEnds front_ends;
  Motion motion;
  Backend backend;
  [[no_unique_address]] MapT map;
  Estimate<S> estimate;
  WorldFrameUncertainty<S> world_uncertainty;  ///< of the published pose
  TimeNs last_usable_ns = 0;                   ///< time of the last frame with a usable image, or at rest [ns]
  int full_windows = 0;                        ///< number of full windows that were solved

  Window& window() { return backend.window(); }
  const Window& window() const { return backend.window(); }

  /// Mean motion of the landmarks in the image since the last keyframe [px]; 0 when none is seen in both.
  double motion_px() const { return landmarks.motion_since(keyframe_); }
  /// The same without landmarks that moved more than three times the mean: drifting tracks and moving objects.
  double robust_motion_px() const { return landmarks.motion_since(keyframe_, 3 * motion_px()); }
  int keyframe() const { return keyframe_; }  ///< slot of the last keyframe
  S mean_depth() const { return landmarks.template mean_depth<S>(); }

  /// The view of a new frame, next to the previous image. Applies the latest calibration and integrates the IMU.
  View<Sensors> view_of(const typename Sensors::Frame& frame, bool is_first) {
    const S dt = S(seconds_between(estimate.t_ns, frame.t_ns));
    const State latest = window().latest();
    estimate.time_offset_s = motion.calibrate(rig_state, window());
    estimate.T_body_cam = rig_state.T_body_cam();
    motion.begin_frame(frame.t_ns, is_first ? nullptr : &latest, dt);
    auto view = images.view(rig, frame, motion.T_body_cam(estimate.T_body_cam), rig_state.readout(), dt);
    set_shutter_motion(*this, view, latest);
    return view;
  }

  /// Predicts the state of the frame, and from it the motion during its readout.
  Predicted predict(View<Sensors>& view) {
    const auto align_motion = [&](const SE3<S>& guess) {
      return images.align_motion(view, guess, mean_depth(), is_after_gap(view.t_ns));
    };
    const Predicted predicted = motion.predict(window().latest(), view, S(outage_s(view.t_ns)), align_motion);
    set_shutter_motion(*this, view, predicted.state);
    return predicted;
  }

  /// Tracks all features from the previous image and sets T to the RANSAC consensus; returns the reason of a failure.
  /// Without an IMU, after a gap, a few inliers are no consensus: they may agree by chance.
  HealthReason follow(const View<Sensors>& view, const Predicted& predicted, SE3<S>& T) {
    front_ends.follow(view, window(), landmarks, T);
    const auto [candidates, inliers] =
        front_ends.find_consensus(view, window(), landmarks, options.ransac, T,
                                  [&](const SE3<S>& x) { return motion.passes_gate(predicted, x); });
    const bool few = inliers < options.recovery.min_landmarks && 2 * inliers < candidates;
    return !Motion::has_imu_factors && is_after_gap(view.t_ns) && few ? HealthReason::few_inliers : HealthReason::none;
  }

  /// Estimates the pose: once with all features, once without outliers, once with the features located again from that
  /// pose. Returns the reason of a failure.
  HealthReason find_pose(View<Sensors>& view, const Predicted& predicted, SE3<S>& T, Covariance& covariance) {
    const auto refine = [&] {
      return pose_.refine(rig, view.T_body_cam, landmarks, window(), predicted.state.T_world_body, predicted.prior, T,
                          covariance);
    };
    HealthReason failure = refine();
    if (failure == HealthReason::none) {
      update_frame_motion(*this, view, predicted.state, T);
      failure = refine();
    }
    if (failure == HealthReason::none) {
      front_ends.refine(view, window(), landmarks, T);
      failure = refine();
    }
    if (failure != HealthReason::none) return failure;
    if (motion.contradicts(predicted, T)) return HealthReason::imu_disagrees;
    update_keyframe_motion(*this, view, predicted.state, T);
    set_ranges(landmarks, window(), view, T, readout_s(), /*all=*/false);
    return HealthReason::none;
  }
  /// Covariance of the frame's position by its features, scaled by their residuals.  docs/math/initialization.md (7b)
  Mat<S, 3, 3> position_noise(const Covariance& covariance) const {
    return pose_.noise_scale2() * block<3, 3>(covariance, 3, 3);
  }

  /// Accepts the pose of a frame without IMU factors. It enters the window only as a keyframe.
  void adopt_pose(const View<Sensors>& view, const State& x, const Covariance& covariance) {
    window().set_latest(x);
    images.keep(view, x.T_world_body);
    publish(view.t_ns);
    // Covariance of the keyframe, carried to this body by the adjoint, plus that of the motion since.
    publish(carried(keyframe_covariance_, window().T_world_body(keyframe_), x.T_world_body) + covariance);
    locate(view);
    last_usable_ns = view.t_ns;
  }
  bool needs_keyframe(TimeNs t_ns) {
    const double rad = motion_px() / double(effective_focal_length(rig.vision.camera));
    const bool needed = rule_.is_keyframe(landmarks.tracked_count(), tracked_at_keyframe_, rad);
    return motion.confirm_keyframe(
        t_ns, [&] { return robust_motion_px(); }, needed);
  }
  /// Makes the latest frame, accepted by adopt_pose, a keyframe.
  void make_keyframe(const View<Sensors>& view) {
    const int slot = backend.insert(view.t_ns, window().latest(), motion.factor(keyframe_));
    detect_landmarks(view, slot);
    backend.optimize(rig, view.T_body_cam, landmarks);
    if (find_readout(*this, view)) backend.optimize(rig, view.T_body_cam, landmarks);
    window().set_latest(slot);
    adopt_keyframe(view, slot);
    make_room(view);
  }

  /// Inserts a frame with IMU factors into the window. Unless it becomes a keyframe it is temporary, and is removed
  /// without marginalization when the next frame comes. Returns whether it is to become a keyframe.
  bool insert_into_window(const View<Sensors>& view, State x) {
    const bool was_stationary = motion.is_stationary(), keyframe = needs_keyframe(view.t_ns);
    is_stationary_ = was_stationary && motion.is_stationary();
    was_stationary && !is_stationary_ ? keep_temporary(view) : drop_temporary();
    if (is_stationary_) x.T_world_body = window().latest().T_world_body;
    temporary_ = backend.insert(view.t_ns, x, motion.factor(keyframe_));
    return keyframe;
  }
  /// Optimizes the window with the frame as a keyframe, or as none; `before` is the state of the previous frame. At
  /// rest the window is not optimized, so noise does not move the pose.
  void solve_in_window(const View<Sensors>& view, const State& before, bool keyframe) {
    if (keyframe) {
      detect_landmarks(view, temporary_);
    } else {
      landmarks.for_each([&](auto& store) { store.record(temporary_); });
    }
    if (is_stationary_) return window().set_latest(temporary_);
    backend.optimize(rig, view.T_body_cam, landmarks, keyframe);
    if (keyframe && find_readout(*this, view)) backend.optimize(rig, view.T_body_cam, landmarks);
    window().set_latest(temporary_);
    if (State solved = window().latest(); motion.correct(before, solved, view.dt)) window().set_latest(solved);
  }
  /// Estimates the depth of landmarks that have none yet, from the latest frame.
  void locate(const View<Sensors>& view) {
    front_ends.locate(view, window(), landmarks, window().latest().T_world_body);
  }
  void publish_in_window(const View<Sensors>& view) {
    images.keep(view, window().latest().T_world_body);
    publish(last_usable_ns = view.t_ns);
    if (is_stationary_) return;
    using SolvedLayout = std::conditional_t<HasVelocityCovariance<Backend>, MovingLayout, VisualLayout>;
    Mat<S, SolvedLayout::dim, SolvedLayout::dim> P;
    if (!backend.covariance_of_newest(P)) set_identity(P);
    publish(block<state::Pose::dim, state::Pose::dim>(P, 0, 0));
    if constexpr (HasVelocityCovariance<Backend>) {
      motion.set_velocity_covariance(P);
      motion.set_speed_covariance(P, window().latest().v_world_body);
    }
  }
  void keep_as_keyframe(const View<Sensors>& view) {
    adopt_keyframe(view, temporary_);
    temporary_ = none;
    make_room(view);
  }

  /// Makes `slot` the last keyframe.
  void adopt_keyframe(const View<Sensors>& view, int slot) {
    const State x = window().latest();
    images.keep(view, x.T_world_body);
    keyframe_ = slot;
    tracked_at_keyframe_ = landmarks.tracked_count();
    motion.begin_factor(x);
    estimate.keyframe = true;
    const bool has_covariance = backend.covariance_of_newest(keyframe_covariance_);
    if (Motion::has_imu_factors && !motion.is_initialized()) return;  // its world frame is not the published one
    estimate.T_world_body = x.T_world_body;
    if (has_covariance) publish(keyframe_covariance_);
    if constexpr (Motion::has_imu_factors && !HasVelocityCovariance<Backend>) {
      Mat<S, MovingLayout::dim, MovingLayout::dim> P;
      if (backend.covariance_of_keyframe(P)) motion.set_speed_covariance(P, x.v_world_body);
    }
  }
  /// Retires a keyframe from a full window, so that there is a slot for the next frame.
  void make_room(const View<Sensors>& view) {
    if (!window().full()) return;
    // The oldest one, where neighbors in time are connected: by scale without depth, by IMU factors.
    constexpr bool in_order = Motion::has_imu_factors || !Sensors::has_depth;
    const int slot = KeyframeRule::leaving(window(), mean_depth(), in_order);
    backend.retire(rig, view.T_body_cam, landmarks, slot, map);
  }
  void drop_temporary() {
    if (temporary_ != none) backend.drop(landmarks, std::exchange(temporary_, none));
  }

  /// Makes the last stationary frame a keyframe, so that the next frames have a factor to its zero velocity.
  void keep_temporary(const View<Sensors>& view) {
    if (temporary_ != none) keyframe_ = std::exchange(temporary_, none);
    make_room(view);
  }

  /// Initialization is complete: the latest frame is the last keyframe, IMU factors start there.
  void set_initialized(const View<Sensors>& view) {
    front_ends.end_initialization(landmarks);
    last_usable_ns = view.t_ns;
    publish(view.t_ns);
    adopt_keyframe(view, keyframe_);
  }

  /// Removes all landmarks and frames, and inserts the frame as first keyframe at x. Returns its slot.
  int reset(const View<Sensors>& view, const State& x) {
    landmarks.for_each([](auto& store) { store.clear(); });
    front_ends.begin_initialization();
    temporary_ = none;
    start_readout(*this);
    const int slot = backend.start(view.t_ns, x);
    window().set_latest(slot);
    front_ends.detect(view, window(), landmarks, slot);
    set_zero(keyframe_covariance_);
    return slot;
  }

  void publish(TimeNs t_ns) {
    const State x = window().latest();
    estimate.t_ns = t_ns;
    estimate.T_world_body = x.T_world_body;
    world_uncertainty.move_to(x.T_world_body);
    estimate.keyframe = false;
    estimate.tracked = landmarks.tracked_count();
    const bool few = estimate.tracked < 2 * options.pose.min_inliers;
    HealthReason reason = motion.diagnose(backend.factors(), window(), few);
    if (reason == HealthReason::none && few) reason = HealthReason::few_features;
    set_health(reason == HealthReason::none ? HealthState::tracking : HealthState::degraded, reason);
    if constexpr (Motion::Layout::template has<state::Velocity>) {
      if (!motion.is_initialized()) return;
      estimate.v_world_body = x.v_world_body;
      estimate.bias_gyro = x.bias_gyro;
      estimate.bias_accel = x.bias_accel;
    }
  }
  /// Publishes the covariance P of the window, with the uncertainty of the world frame.
  void publish(const Covariance& P) { estimate.covariance = P + world_uncertainty.at(estimate.T_world_body); }
  void set_health(HealthState state, HealthReason reason) { estimate.health = {state, reason}; }
  double outage_s(TimeNs t_ns) const { return seconds_between(last_usable_ns, t_ns); }
  bool is_after_gap(TimeNs t_ns) const { return outage_s(t_ns) > options.recovery.gap_s; }

  S readout_s() const { return rig_state.readout().value_s; }

 private:
  static constexpr int none = -1;
  /// Detects landmarks in the keyframe of that slot.
  void detect_landmarks(const View<Sensors>& view, int slot) {
    front_ends.detect(view, window(), landmarks, slot);
    set_ranges(landmarks, window(), view, window().T_world_body(slot), readout_s(), /*all=*/true);
  }
  Pose pose_;
  KeyframeRule rule_;
  int keyframe_ = 0, temporary_ = none;  ///< slots of the last keyframe, and of the latest frame if it is none
  int tracked_at_keyframe_ = 0;
  bool is_stationary_ = false;  ///< the body is at rest, in this frame and the previous one
  Covariance keyframe_covariance_ = zeros<Covariance>();
};

}  // namespace plumbline
