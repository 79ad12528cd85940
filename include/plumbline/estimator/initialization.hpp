#pragma once
/// Initialization of an estimator: the map and, with an IMU, scale, gravity, velocities and biases. It drives an
/// initializer (initialization/) with the frames of the odometry.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/dead_reckoned_pose.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/initialization/scale_verification.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class Odometry, class InitializerT>
class Initialization {
 public:
  using Initializer = InitializerT;
  using Sensors = typename Odometry::Sensors;
  using S = typename Odometry::S;
  using State = typename Odometry::State;

  explicit Initialization(const typename Odometry::Options& options)
      : initializer_(options.initialization), output_(options) {
    if constexpr (verifies_scale) scale_verification_ = ScaleVerification(options.initialization.scale_verification);
  }

  const InitReport& report() const { return report_; }
  bool has_started() const { return stage_ != Stage::nothing; }
  bool has_first_view() const { return stage_ == Stage::one_view || has_map(); }
  bool has_map() const { return stage_ == Stage::map; }

  /// Updates the verification of the scale after the initialization of a rig without depth.
  void verify_scale(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (verifies_scale) {
      if (report_.stage != InitStage::done) return;
      const Health health = odometry.estimate.health;
      scale_verification_.update(seconds_between(report_.done_ns, view.t_ns), double(view.dt),
                                 health.reason == HealthReason::imu_disagrees, odometry.motion.speed(),
                                 odometry.motion.speed_sigma());
      if (!scale_verification_.has_converged() && health.state == HealthState::tracking)
        odometry.set_health(HealthState::degraded, HealthReason::scale_uncertain);
    }
  }
  /// Whether the initialization is to be rejected, because IMU and images contradict each other since.
  bool is_rejected() const {
    if constexpr (verifies_scale)
      return report_.stage == InitStage::done && scale_verification_.is_rejected();
    else
      return false;
  }

  /// Frames without a pose before a reset. With an IMU it is 0: the alignment needs an unbroken series of poses.
  int lost_frame_limit(int max_lost_frames) const { return is_complete ? max_lost_frames : 0; }

  /// Propagates the last published pose by the IMU until initialization is complete.
  void dead_reckon(const Odometry& odometry, const View<Sensors>& view) { output_.advance(odometry, view); }
  /// Prepares a reset: keeps the published pose and its covariance, with unknown velocity.
  void mark_lost(Odometry& odometry) {
    if constexpr (verifies_scale) {
      if (is_rejected()) {
        ++report_.rejected;
        output_.discard_path(odometry, first_view_ns_, initializer_.options().gyro_bias_sigma);
      }
    }
    output_.mark_lost(odometry);
  }

  /// Starts an initialization with this frame as its first keyframe, at the published pose after a reset.
  void set_first_view(Odometry& odometry, const View<Sensors>& view) {
    output_.reset(odometry);
    stage_ = Stage::no_view;
    report_ = {.rejected = report_.rejected};
    const int slot = odometry.reset(view, odometry.motion.restart(odometry.window().latest()));
    Estimate<S>& estimate = odometry.estimate;
    estimate.t_ns = view.t_ns;
    estimate.tracked = 0;
    estimate.keyframe = false;
    report_.features = odometry.landmarks.seen_count();
    const int usable =
        is_complete && !Initializer::needs_second_view ? odometry.landmarks.tracked_count() : report_.features;
    const int needed = odometry.options.recovery.min_landmarks;
    if (usable < needed) {
      const bool has_features = report_.features >= needed;
      wait(odometry, has_features ? HealthReason::no_depth : HealthReason::few_features, InitStage::few_features);
      return;
    }
    first_view_ns_ = view.t_ns;
    stage_ = Initializer::needs_second_view ? Stage::one_view : Stage::map;
    if constexpr (is_complete && !Initializer::needs_second_view) {
      finish(view);
      odometry.publish(view.t_ns);
    }
    odometry.adopt_keyframe(view, slot);
    if constexpr (!is_complete || Initializer::needs_second_view)
      wait(odometry, HealthReason::aligning,
           Initializer::needs_second_view ? InitStage::little_parallax : InitStage::aligning);
    start_series(odometry, view);
  }

  /// Tracks the corners of the first view until the parallax to the frame suffices for a second view.
  void find_second_view(Odometry& odometry, const View<Sensors>& view, const State& predicted) {
    if constexpr (Initializer::needs_second_view) {
      auto& initializer = initializer_.visual();
      const SE3<S> T_world_first = odometry.window().T_world_body(odometry.keyframe());
      State x = predicted;
      x.T_world_body = SE3<S>(predicted.T_world_body.rotation(), T_world_first.p());
      odometry.front_ends.follow(view, odometry.window(), odometry.landmarks, x.T_world_body);
      odometry.window().set_latest(x);
      odometry.images.keep(view, x.T_world_body);
      odometry.estimate.t_ns = odometry.last_usable_ns = view.t_ns;
      initializer.clear_pairs();
      odometry.front_ends.for_each_pair(
          view, odometry.landmarks, odometry.keyframe(),
          [&](const Vec<S, 3>& f1, const Vec<S, 3>& f2) { initializer.add_pair(f1, f2); });
      odometry.landmarks.for_each([](auto& store) { store.prune(); });
      report_.features = initializer.pairs();
      wait(odometry, HealthReason::aligning, InitStage::little_parallax);
      const double motion_px = odometry.robust_motion_px();
      const bool is_stationary = is_stationary_at(odometry, view.t_ns, motion_px);
      if (initializer.has_expired(seconds_between(first_view_ns_, view.t_ns)) ||
          (is_stationary ? has_drifted(odometry, motion_px) : detect_stop(odometry, view.t_ns, motion_px))) {
        set_first_view(odometry, view);
      }
      if (is_stationary) publish_stationary(odometry);
      if (is_stationary || first_view_ns_ == view.t_ns || !has_first_view()) return;
      const SO3<S> R_world_first = T_world_first.rotation() * view.T_body_cam.rotation();
      const SO3<S> R_2_1 = (x.T_world_body.rotation() * view.T_body_cam.rotation()).inverse() * R_world_first;
      if (!initializer.solve(R_2_1, report_)) return;
      x.T_world_body = T_world_first * view.T_body_cam * initializer.T_1_2() * view.T_body_cam.inverse();
      odometry.window().set_latest(x);
      odometry.front_ends.locate(view, odometry.window(), odometry.landmarks, x.T_world_body);
      stage_ = Stage::map;
      odometry.publish(view.t_ns);
      const int first = odometry.keyframe();
      odometry.make_keyframe(view);
      odometry.backend.hold_scale(first, odometry.keyframe());
      if constexpr (is_complete) {
        finish(view);
      } else {
        wait(odometry, HealthReason::aligning, InitStage::aligning);
      }
      start_series(odometry, view);
    }
  }

  /// Adds the frame's pose, with its covariance, to the poses of the alignment. True when an alignment is to be tried,
  /// for which the frame becomes a keyframe.
  bool add_pose(Odometry& odometry, const View<Sensors>& view, const typename Odometry::Covariance& covariance) {
    if constexpr (is_complete) {
      // Initialization points are removed as soon as the landmarks of the other kinds suffice.
      if (odometry.front_ends.lasting_count(odometry.landmarks) >= 2 * odometry.options.recovery.min_landmarks) {
        odometry.front_ends.end_initialization(odometry.landmarks);
      }
      return false;
    } else {
      publish_up_to_scale(odometry);
      return initializer_.add(view.t_ns, odometry.window().latest().T_world_body * view.T_body_cam,
                              odometry.position_noise(covariance), odometry.motion.imu().since_frame(),
                              odometry.rig_state);
    }
  }
  /// Aligns poses and IMU. On success the map is scaled, the world turned upright and the window restarted.
  void align(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (!is_complete) {
      const SE3<S>& T_body_cam = odometry.rig_state.T_body_cam();
      const auto& window = odometry.window();
      for (int slot = 0; slot < window.slots; ++slot) {
        if (window[slot].used) initializer_.correct(window[slot].t_ns, window.T_world_body(slot) * view.T_body_cam);
      }
      if (!initializer_.align(T_body_cam, odometry.options.motion.gravity, report_) ||
          !initializer_.is_time_offset_known(odometry.motion.camera_imu(), seconds_between(first_view_ns_, view.t_ns)))
        return initializer_.is_contradicted() ? reject(odometry, view) : publish_up_to_scale(odometry);
      const State before = odometry.window().latest();
      odometry.landmarks.for_each([&](auto& store) { store.rescale(initializer_.scale()); });
      restart_window(odometry,
                     [&](int slot) { return output_.state_of(initializer_, window.T_world_body(slot), T_body_cam); });
      const double length = baseline(window);
      solve(odometry, length);
      // The second restart linearizes at the solution: the states of the alignment are too inaccurate for that.
      restart_window(odometry, [&](int slot) { return window[slot].state.value(); });
      solve(odometry, length);
      const State x = odometry.window().latest();
      const bool is_offset_known =
          initializer_.verify_time_offset(window.time_offset_s(odometry.rig_state.time_offset_s()));
      if (!is_offset_known) odometry.motion.adopt_time_offset(window);
      if (!is_offset_known || !initializer_.is_plausible(x)) {
        odometry.window().set_latest(before);
        return reject(odometry, view);
      }
      odometry.motion.set_initialized();
      output_.set_initialized(odometry, initializer_);
      finish(view);
      odometry.set_initialized(view);
    }
  }

 private:
  enum class Stage : std::uint8_t { nothing, no_view, one_view, map };
  /// Whether a map completes the initialization (rigs without IMU).
  static constexpr bool is_complete = !Odometry::Motion::has_imu_factors;
  /// Whether the scale is determined by images and IMU together (rigs with an IMU and without depth).
  static constexpr bool verifies_scale = !is_complete && Initializer::needs_second_view;

  void wait(Odometry& odometry, HealthReason reason, InitStage stage) {
    report_.stage = stage;
    odometry.set_health(odometry.estimate.resets > 0 ? HealthState::lost : HealthState::initializing, reason);
    output_.publish(odometry);
  }
  /// Rejects the initialization and starts another one with this frame.
  void reject(Odometry& odometry, const View<Sensors>& view) {
    ++report_.rejected;
    set_first_view(odometry, view);
    report_.stage = InitStage::rejected;
  }
  void finish(const View<Sensors>& view) {
    report_.stage = InitStage::done;
    report_.done_ns = view.t_ns;
    if constexpr (verifies_scale) scale_verification_.begin();
  }

  void start_series(Odometry& odometry, const View<Sensors>& view) {
    odometry.last_usable_ns = view.t_ns;
    if constexpr (!is_complete) {
      initializer_.clear();
      initializer_.add(view.t_ns, odometry.window().latest().T_world_body * view.T_body_cam, zeros<Mat<S, 3, 3>>(),
                       odometry.motion.imu().since(odometry.window().latest()), odometry.rig_state);
    }
  }

  void publish_up_to_scale(Odometry& odometry) {
    wait(odometry, HealthReason::aligning, InitStage::aligning);
    if (initializer_.has_estimate()) output_.publish_up_to_scale(odometry, initializer_);
  }
  /// Restarts the window: IMU factors are active from now on, the prior is that of the alignment.
  void restart_window(Odometry& odometry, auto&& state_of) {
    odometry.backend.restart(state_of, initializer_.prior_on_biases(), odometry.rig_state.T_body_cam(),
                             odometry.motion.time_offset(initializer_.options().max_time_sigma_s));
  }
  static double baseline(const auto& window) {
    return double(norm(window.T_world_body(window.newest()).p() - window.T_world_body(window.oldest()).p()));
  }
  /// Optimizes the window, with the distance `length` [m] between its oldest and newest frame held by the sigma of the
  /// scale, because the window alone may not determine the scale. The sigma is at least min_scale_sigma of the length,
  /// because the errors of the aligned poses are correlated.
  void solve(Odometry& odometry, double length) {
    const auto& window = odometry.window();
    if constexpr (Initializer::needs_second_view) {
      const auto& options = initializer_.options();
      const double noise = options.alignment.position_sigma * double(initializer_.scale());
      const double sigma = std::hypot(std::max(initializer_.scale_sigma(), options.min_scale_sigma) * length, noise);
      if (window.size() > 1) odometry.backend.hold_distance(window.oldest(), window.newest(), length, sigma);
    }
    LevenbergMarquardtOptions solver = odometry.options.backend.solver;
    solver.max_iterations *= 2;
    odometry.backend.optimize(odometry.rig, odometry.rig_state.T_body_cam(), odometry.landmarks, solver);
  }

  static bool is_stationary_at(Odometry& odometry, TimeNs t_ns, double motion_px) {
    if constexpr (is_complete)
      return false;
    else
      return odometry.motion.detect_stationarity(t_ns, motion_px);
  }
  /// Whether tracks of a stationary body have drifted so far that a new first view is needed.
  static bool has_drifted(const Odometry& odometry, double motion_px) {
    if constexpr (is_complete)
      return false;
    else
      return motion_px > odometry.options.motion.stationary_motion_px;
  }
  /// Whether the body has stopped at some distance from its first view: its mean image motion has not changed for
  /// stationary_check_s, and the IMU is stationary.
  bool detect_stop(Odometry& odometry, TimeNs t_ns, double motion_px) {
    if constexpr (is_complete) {
      return false;
    } else {
      const auto& options = odometry.options.motion;
      if (!(std::abs(motion_px - reference_motion_px_) < options.stationary_motion_px)) {
        reference_motion_px_ = motion_px;
        unchanged_since_ns_ = t_ns;
      }
      return seconds_between(unchanged_since_ns_, t_ns) > options.stationary_check_s &&
             odometry.motion.can_be_stationary(t_ns);
    }
  }
  void publish_stationary(Odometry& odometry) {
    if constexpr (!is_complete) output_.publish_stationary(odometry, initializer_.options().accel_bias_sigma);
  }

  struct Nothing {};
  using Output =
      std::conditional_t<is_complete, HoldLastPose<Odometry, Initializer>, DeadReckonedPose<Odometry, Initializer>>;
  using ScaleVerifier = std::conditional_t<verifies_scale, ScaleVerification, Nothing>;

  Initializer initializer_;
  [[no_unique_address]] Output output_;
  [[no_unique_address]] ScaleVerifier scale_verification_;
  Stage stage_ = Stage::nothing;
  TimeNs first_view_ns_ = 0;
  TimeNs unchanged_since_ns_ = 0;   ///< since when the mean image motion has been about reference_motion_px_
  double reference_motion_px_ = 0;  ///< mean motion in the image since the first view [px]
  InitReport report_;
};

}  // namespace plumbline
