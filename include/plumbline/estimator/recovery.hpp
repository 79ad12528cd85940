#pragma once
/// Recovery from frames without a pose: with an IMU, IMU-only propagation; without, repeated attempts against the last
/// usable image; then a reset at the last or dead-reckoned pose.
///                                                                                      docs/concepts/outages.md

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

struct RecoveryOptions {
  /// Fewest landmarks in view for an initialization, or for tracking.
  int min_landmarks = 15;
  /// Frames without a pose before a reset, for rigs without IMU. Images of too little contrast do not count.
  int max_lost_frames = 20;
  /// Time without a usable image after which the rotation of the camera is unknown [s].
  double gap_s = 0.2;
  /// Unusable images in a row before new landmarks are detected, for rigs with an IMU.
  int max_outage_frames = 3;
  /// Longest IMU-only propagation, or wait for a usable image, before a reset [s].
  double max_imu_only_s = 3;
  /// Speed of a body that is not observed, sigma [m/s].
  double lost_speed = 1;
  /// Angular rate of a body that is not observed, sigma [rad/s].
  double lost_rate = 1;
};

/// The default options of a rig: without depth an initialization takes longer, so a reset comes earlier.
template <SensorRig Sensors>
constexpr RecoveryOptions default_recovery() {
  return {.max_lost_frames = Sensors::has_depth ? 20 : 10};
}

template <class Odometry, class Initialization>
class Recovery {
 public:
  using Sensors = typename Odometry::Sensors;
  using S = typename Odometry::S;
  using State = typename Odometry::State;
  using Motion = typename Odometry::Motion;

  /// Starts an initialization with this view, at the published pose after a reset.
  static void start(Odometry& odometry, Initialization& initialization, const View<Sensors>& view) {
    if (!Motion::has_imu_factors && odometry.estimate.resets > 0) {
      mark_lost(odometry, view);
      initialization.mark_lost(odometry);
    }
    initialization.set_first_view(odometry, view);
  }

  void recover(Odometry& odometry, Initialization& initialization, const View<Sensors>& view, const State& predicted,
               HealthReason failure) {
    odometry.motion.mark_lost();
    const int max_lost_frames = initialization.lost_frame_limit(odometry.options.recovery.max_lost_frames);
    const bool continues = odometry.motion.can_propagate() ? propagate_imu_only(odometry, view, predicted, failure)
                                                           : wait(odometry, view, max_lost_frames, failure);
    if (!continues) reset(odometry, initialization, view);
  }
  void reset(Odometry& odometry, Initialization& initialization, const View<Sensors>& view) {
    if (!Motion::has_imu_factors || odometry.motion.can_propagate()) {
      ++odometry.estimate.resets;
      initialization.mark_lost(odometry);
    }
    lost_frames_ = 0;
    imu_only_s_ = 0;
    start(odometry, initialization, view);
  }
  /// A frame has a pose again. A usable frame reduces the time of IMU-only propagation by its own duration, so that
  /// images and IMU that contradict each other in most frames also end in a reset.
  void found_pose(Odometry& odometry, const View<Sensors>& view) {
    if (lost_frames_ > 0) odometry.motion.mark_lost();
    lost_frames_ = 0;
    imu_only_s_ = std::max(0.0, imu_only_s_ - double(view.dt));
  }

 private:
  /// Rigs without IMU: holds the last pose and tries up to max_lost_frames images against the last usable one. Repeated
  /// images and those of too little contrast do not count. Returns false when a reset is due.
  bool wait(Odometry& odometry, const View<Sensors>& view, int max_lost_frames, HealthReason failure) {
    const bool repeats = failure == HealthReason::images_repeat;
    const bool timed_out = !(odometry.outage_s(view.t_ns) < odometry.options.recovery.max_imu_only_s);
    if (!repeats && (max_lost_frames == 0 || odometry.images.has_contrast())) ++lost_frames_;
    if (!repeats && (lost_frames_ > max_lost_frames || timed_out)) return false;
    mark_lost(odometry, view);
    if (!repeats) undo_frame(odometry);
    odometry.estimate.t_ns = view.t_ns;
    odometry.estimate.keyframe = false;
    odometry.estimate.tracked = 0;
    odometry.set_health(repeats && !timed_out ? HealthState::degraded : HealthState::lost, failure);
    return true;
  }
  /// Inflates the covariance of a body that is not observed and may move: constant unknown velocity, sigma^2 t^2.
  static void mark_lost(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (!Motion::has_imu_factors) {
      const RecoveryOptions& options = odometry.options.recovery;
      const double until_s = odometry.outage_s(view.t_ns), since_s = until_s - double(view.dt);
      for (int k = 0; k < state::Pose::dim; ++k) {
        const double sigma = k < 3 ? options.lost_rate : options.lost_speed;
        odometry.estimate.covariance(k, k) += S(sigma * sigma * (until_s * until_s - since_s * since_s));
      }
    }
  }

  /// Takes the prediction of the motion model as the pose. An image with enough landmarks is kept, and gives them depth
  /// by parallax, unless its pose contradicts the IMU. After max_outage_frames images with too few landmarks, new ones
  /// are detected. Returns false when a reset is due and the image has enough landmarks for it.
  bool propagate_imu_only(Odometry& odometry, const View<Sensors>& view, State x, HealthReason failure) {
    const RecoveryOptions& options = odometry.options.recovery;
    const bool repeats = failure == HealthReason::images_repeat,
               contradicts_imu = failure == HealthReason::imu_disagrees;
    // Images that contradict the IMU of a stationary body are to lead to a reset.
    const bool is_stationary = hold_stationary(odometry, view.t_ns, x) && !contradicts_imu;
    auto covariance = odometry.estimate.covariance;  // a keyframe made during the outage does not reduce it
    if (!is_stationary) covariance = odometry.motion.grown_covariance(covariance, S(odometry.outage_s(view.t_ns)));
    odometry.window().set_latest(x);
    bool has_landmarks = !repeats && odometry.landmarks.seen_count() >= options.min_landmarks;
    if (has_landmarks && !contradicts_imu) {
      odometry.images.keep(view, x.T_world_body);
      odometry.locate(view);
    } else if (!repeats && !has_landmarks && ++lost_frames_ > options.max_outage_frames &&
               detect_again(odometry, view)) {
      has_landmarks = true;
      lost_frames_ = 0;
    } else if (!repeats) {
      undo_frame(odometry);
    }
    odometry.publish(view.t_ns);
    odometry.estimate.covariance = covariance;
    odometry.estimate.tracked = 0;
    if (is_stationary) odometry.last_usable_ns = view.t_ns;
    imu_only_s_ = is_stationary ? 0 : imu_only_s_ + double(view.dt);
    const bool lost = !(imu_only_s_ < options.max_imu_only_s);
    odometry.set_health(lost ? HealthState::lost : HealthState::degraded,
                        repeats || contradicts_imu ? failure : HealthReason::imu_only);
    return !lost || !has_landmarks;
  }
  /// Holds the pose of a slow body whose IMU is stationary: noise does not move it during an outage. The limit of the
  /// speed is the uncertainty of the velocity, velocity_sigma, and as much more for each second of the outage.
  static bool hold_stationary(Odometry& odometry, TimeNs t_ns, State& x) {
    if constexpr (Motion::Layout::template has<state::Velocity>) {
      const State& before = odometry.window().latest();
      const double max_speed = odometry.options.motion.velocity_sigma * (1 + odometry.outage_s(t_ns));
      if (!(double(norm(before.v_world_body)) < max_speed) || !odometry.motion.can_be_stationary(t_ns)) return false;
      x.T_world_body = before.T_world_body;
      set_zero(x.v_world_body);
      return true;
    }
    return false;
  }
  /// Detects landmarks at the latest state, which becomes a keyframe, when the image shows enough corners. Earlier
  /// landmarks are not observed in it: the few that were tracked had no consensus.
  static bool detect_again(Odometry& odometry, const View<Sensors>& view) {
    odometry.drop_temporary();
    odometry.landmarks.for_each([](auto& store) { store.clear_current(); });
    const int slot =
        odometry.backend.insert(view.t_ns, odometry.window().latest(), odometry.motion.factor(odometry.keyframe()));
    odometry.front_ends.detect(view, odometry.window(), odometry.landmarks, slot);
    if (odometry.landmarks.seen_count() < odometry.options.recovery.min_landmarks) {
      odometry.backend.drop(odometry.landmarks, slot);
      return false;
    }
    odometry.window().set_latest(slot);
    odometry.adopt_keyframe(view, slot);
    odometry.make_room(view);
    return true;
  }
  static void undo_frame(Odometry& odometry) {
    odometry.landmarks.for_each([](auto& store) { store.undo_frame(); });
  }

  int lost_frames_ = 0;    ///< unusable frames in a row
  double imu_only_s_ = 0;  ///< time of IMU-only propagation, less that of usable frames since [s]
};

}  // namespace plumbline
