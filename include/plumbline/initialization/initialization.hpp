#pragma once
/// Initialization of an estimator: landmarks with depth and, with an IMU, scale, gravity, velocities and biases. It
/// drives an initializer (initialization/) with the frames, and says by events how far it has come.

#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/initialization/aligned_window.hpp"
#include "plumbline/initialization/dead_reckoned_pose.hpp"
#include "plumbline/initialization/first_view_tracks.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/initialization/metric_report.hpp"
#include "plumbline/initialization/scale_verification.hpp"
#include "plumbline/initialization/stop_detector.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/tracking_state.hpp"

namespace plumbline {

/// `Parts`: what the estimator is composed of. Methods take the components `on` that they act on (Components).
template <class Parts>
class Initialization {
 public:
  using Initializer = typename Parts::Initializer;
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Propagation = typename Parts::Propagation;
  using State = typename Propagation::State;
  using Covariance = Mat<S, 6, 6>;

  explicit Initialization(const auto& options)
      : initializer_(options.initialization),
        pose_(Pose(options)),
        min_landmarks_(options.recovery.min_landmarks),
        stop_(options.propagation) {
    if constexpr (!is_complete) solver_ = options.backend.solver;
    solver_.max_iterations *= 2;
    if constexpr (verifies_scale) scale_verification_ = ScaleVerification(options.initialization.scale_verification);
  }

  const InitReport& report() const { return report_; }
  /// Time of the first view [ns].
  TimeNs first_view_ns() const { return first_view_ns_; }

  /// Updates the verification of the scale after the initialization of a rig without depth.
  void verify_scale(const View<Sensors>& view, const Propagation& propagation, bool is_inconsistent) {
    if constexpr (verifies_scale) {
      if (!is_done()) return;
      scale_verification_.update(seconds_between(report_.done_ns, view.t_ns), double(view.dt), is_inconsistent,
                                 propagation.speed(), propagation.speed_sigma());
    }
  }
  /// Whether the scale is verified, or needs no verification.
  bool is_scale_converged() const { return !is_done() || scale_verification_.has_converged(); }
  /// Whether the initialization is to be rejected, because IMU and images contradict each other since.
  bool is_rejected() const { return is_done() && scale_verification_.is_rejected(); }

  /// Frames without a pose before a reset. With an IMU it is 0: the alignment needs an unbroken series of poses.
  static int lost_frame_limit(int max_lost_frames) { return is_complete ? max_lost_frames : 0; }

  /// Propagates the last pose by the IMU until initialization is complete.
  void dead_reckon(const Propagation& propagation, S dt) { pose_.advance(propagation, dt); }
  /// Prepares a reset: keeps pose and covariance of the navigation state, with unknown velocity.
  void mark_lost(auto& window, auto& navigation) {
    if constexpr (verifies_scale) {
      if (is_rejected()) {
        ++report_.rejected;
        pose_.discard_path(window, navigation, first_view_ns_, initializer_.options().gyro_bias_sigma);
      }
    }
    pose_.mark_lost(window.latest(), navigation);
  }

  /// Starts an initialization with this frame as its first keyframe, at the navigation pose after a reset.
  void set_first_view(const View<Sensors>& view, auto&& on) {
    if (pose_.reset(on.propagation.is_stationary(), on.navigation)) on.status.count_reset();
    report_ = {.rejected = report_.rejected};
    on.report = {};
    const int slot =
        on.window.reset(view, on.propagation.restart(on.window.frames().latest()), on.tracker, on.rig_state);
    const auto& landmarks = on.window.landmarks();
    report_.features = landmarks.seen_count();
    const int usable = is_complete && !Initializer::needs_second_view ? landmarks.tracked_count() : report_.features;
    if (usable < min_landmarks_) {
      on.status.handle(TrackingEvent::image_unusable);
      wait(report_.features < min_landmarks_ ? HealthReason::few_features : HealthReason::no_depth,
           InitStage::few_features, on);
      return;
    }
    first_view_ns_ = view.t_ns;
    on.status.handle(TrackingEvent::first_view);
    if constexpr (is_complete && !Initializer::needs_second_view) {
      finish(view, on);
      on.window.accept_latest(on.propagation, on.navigation, on.report);
    }
    on.window.adopt_keyframe(view, slot, on.tracker, on.propagation, on.navigation);
    if constexpr (Initializer::needs_second_view) {
      wait(HealthReason::aligning, InitStage::little_parallax, on);
    } else if constexpr (!is_complete) {
      on.status.handle(TrackingEvent::landmarks_located);
      wait(HealthReason::aligning, InitStage::aligning, on);
    }
    start_series(view, on);
  }

  /// Tracks the corners of the first view until the parallax to the frame suffices for a second view. `distance`: that
  /// of the frame from the first view, where a map knows it, else 0.
  void find_second_view(const View<Sensors>& view, const State& predicted, S distance, auto&& on) {
    if constexpr (Initializer::needs_second_view) {
      auto& initializer = initializer_.visual();
      auto& frames = on.window.frames();
      auto& landmarks = on.window.landmarks();
      const SE3<S> T_world_first = frames.T_world_body(on.window.keyframe());
      State x = follow_first_view(view, predicted, initializer, on);
      report_.features = initializer.pairs();
      wait(HealthReason::aligning, InitStage::little_parallax, on);
      const double track_px = on.window.robust_motion_px();
      const bool is_stationary = on.propagation.detect_stationarity(view.t_ns, track_px);
      if (initializer.has_expired(seconds_between(first_view_ns_, view.t_ns)) ||
          (is_stationary ? stop_.has_drifted(track_px)
                         : stop_.has_stopped(view.t_ns, track_px) && on.propagation.can_be_stationary(view.t_ns)))
        set_first_view(view, on);
      if constexpr (!is_complete) {
        if (is_stationary) report_stationary(pose_, initializer_, on);
      }
      if (is_stationary || first_view_ns_ == view.t_ns || !on.status.has_first_view()) return;
      if (!initializer.solve(rotation_since_first_view(T_world_first, x.T_world_body, view.T_body_cam), report_))
        return;
      x.T_world_body = T_world_first * view.T_body_cam * initializer.T_1_2(distance) * view.T_body_cam.inverse();
      frames.set_latest(x);
      on.tracker.locate(view, frames, landmarks);
      on.window.accept_latest(on.propagation, on.navigation, on.report);
      const int first = on.window.keyframe();
      on.window.make_keyframe(view, on.tracker, on.propagation, on.rig_state, on.navigation);
      on.window.backend().hold_scale(first, on.window.keyframe());
      if constexpr (is_complete) {
        finish(view, on);
      } else {
        on.status.handle(TrackingEvent::landmarks_located);
        wait(HealthReason::aligning, InitStage::aligning, on);
      }
      start_series(view, on);
    }
  }

  /// Adds the frame's pose, with its covariance, to the poses of the alignment. True when an alignment is to be tried,
  /// for which the frame becomes a keyframe.
  bool add_pose(const View<Sensors>& view, const Covariance& covariance, auto&& on) {
    if constexpr (is_complete) {
      // Initialization points are removed as soon as the landmarks of the other kinds suffice.
      auto& front_ends = on.tracker.front_ends();
      auto& landmarks = on.window.landmarks();
      if (front_ends.lasting_count(landmarks) >= 2 * min_landmarks_) front_ends.end_initialization(landmarks);
      return false;
    } else {
      apply_up_to_scale(on);
      return initializer_.add(view.t_ns, on.window.frames().latest().T_world_body * view.T_body_cam,
                              on.tracker.position_noise(covariance), on.propagation.imu().since_frame(), on.rig_state);
    }
  }
  /// Aligns poses and IMU. On success the landmarks are scaled, the world turned upright and the window restarted.
  void align(const View<Sensors>& view, auto&& on) {
    if constexpr (!is_complete) {
      const SE3<S>& T_body_cam = on.rig_state.T_body_cam();
      auto& frames = on.window.frames();
      correct_poses(initializer_, frames, view.T_body_cam);
      if (!initializer_.align(T_body_cam, on.propagation.options().gravity, report_) ||
          !initializer_.is_time_offset_known(on.propagation.camera_imu(), seconds_between(first_view_ns_, view.t_ns)))
        return initializer_.is_contradicted() ? reject(view, on) : apply_up_to_scale(on);
      const State before = frames.latest();
      solve_aligned_window(initializer_, solver_, view, on.window, on.propagation, T_body_cam, [&](int slot) {
        return pose_.state_of(initializer_, frames.T_world_body(slot), T_body_cam);
      });
      const State x = frames.latest();
      const bool is_offset_known = initializer_.verify_time_offset(frames.time_offset_s(on.rig_state.time_offset_s()));
      if (!is_offset_known) on.propagation.adopt_time_offset(frames);
      if (!is_offset_known || !initializer_.is_plausible(x)) {
        frames.set_latest(before);
        return reject(view, on);
      }
      on.window.transform_map(pose_.similarity(initializer_, T_body_cam), T_body_cam);
      on.propagation.set_initialized();
      pose_.set_initialized(frames, initializer_, on.navigation);
      finish(view, on);
      on.tracker.front_ends().end_initialization(on.window.landmarks());
      on.tracker.set_usable(view.t_ns);
      on.window.accept_latest(on.propagation, on.navigation, on.report);
      on.window.adopt_keyframe(view, on.window.keyframe(), on.tracker, on.propagation, on.navigation);
    }
  }

 private:
  /// Whether landmarks complete the initialization (rigs without IMU).
  static constexpr bool is_complete = !Propagation::has_imu_factors;
  /// Whether the scale is determined by images and IMU together (rigs with an IMU and without depth).
  static constexpr bool verifies_scale = !is_complete && Initializer::needs_second_view;

  bool is_done() const { return report_.stage == InitStage::done; }

  void wait(HealthReason reason, InitStage stage, auto&& on) {
    report_.stage = stage;
    on.report.reason = reason;
    on.report.has_metric_pose = false;
    pose_.apply(on.navigation);
  }
  /// Rejects the initialization and starts another one with this frame.
  void reject(const View<Sensors>& view, auto&& on) {
    ++report_.rejected;
    on.window.reject_map();
    on.status.handle(TrackingEvent::initialization_rejected);
    set_first_view(view, on);
    report_.stage = InitStage::rejected;
  }
  void finish(const View<Sensors>& view, auto&& on) {
    report_.stage = InitStage::done;
    report_.done_ns = view.t_ns;
    on.status.handle(TrackingEvent::initialized);
    scale_verification_.begin();
  }

  void start_series(const View<Sensors>& view, auto&& on) {
    on.tracker.set_usable(view.t_ns);
    if constexpr (!is_complete) {
      const State& x = on.window.frames().latest();
      initializer_.clear();
      initializer_.add(view.t_ns, x.T_world_body * view.T_body_cam, zeros<Mat<S, 3, 3>>(),
                       Preintegration<S>(on.propagation.imu().noise()), on.rig_state);
    }
  }

  void apply_up_to_scale(auto&& on) {
    wait(HealthReason::aligning, InitStage::aligning, on);
    report_up_to_scale(pose_, initializer_, on);
  }

  using Pose = std::conditional_t<is_complete, HoldLastPose<S>, DeadReckonedPose<S>>;
  using ScaleVerifier = std::conditional_t<verifies_scale, ScaleVerification, NoScaleVerification>;

  Initializer initializer_;
  [[no_unique_address]] Pose pose_;
  [[no_unique_address]] ScaleVerifier scale_verification_;
  LevenbergMarquardtOptions solver_;
  int min_landmarks_;
  StopDetector stop_;
  TimeNs first_view_ns_ = 0;
  InitReport report_;
};

}  // namespace plumbline
