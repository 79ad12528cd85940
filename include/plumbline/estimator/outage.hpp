#pragma once
/// Frames without a pose: IMU-only propagation with an IMU; without, the last pose is held and images are tried against
/// the last usable one. When neither bridges the outage any longer, a reset is due.      docs/concepts/outages.md

#include <algorithm>

#include "plumbline/core/time.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/estimator/keyframe_window.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/propagation/covariance_growth.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/tracking_state.hpp"

namespace plumbline {

template <class Parts, class MapT>
class Outage {
 public:
  using Window = KeyframeWindow<Parts, MapT>;
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Propagation = typename Parts::Propagation;
  using State = typename Propagation::State;
  using Tracker = typename Window::Tracker;
  using Nav = typename Window::Nav;

  explicit Outage(const EstimatorOptions<Parts>& options) : options_(options.recovery) {
    if constexpr (Propagation::has_imu_factors) velocity_sigma_ = options.propagation.velocity_sigma;
  }

  /// A frame has a pose again. A usable frame reduces the time of IMU-only propagation by its own duration, so that
  /// images and IMU that contradict each other in most frames also end in a reset.
  void found_pose(Propagation& propagation, const View<Sensors>& view) {
    if (lost_frames_ > 0) propagation.mark_lost();
    lost_frames_ = 0;
    imu_only_s_ = std::max(0.0, imu_only_s_ - double(view.dt));
  }
  void reset() {
    lost_frames_ = 0;
    imu_only_s_ = 0;
  }

  /// A frame without a pose: `predicted` is propagated, or the last pose is held. False when a reset is due.
  bool bridge(const View<Sensors>& view, HealthReason failure, const State& predicted, int max_lost_frames,
              const Components<Parts, MapT>& on) {
    on.propagation.mark_lost();
    on.status.handle(failure == HealthReason::images_repeat   ? TrackingEvent::image_unusable
                     : failure == HealthReason::imu_disagrees ? TrackingEvent::imu_vision_inconsistent
                                                              : TrackingEvent::no_pose);
    return on.propagation.can_propagate()
               ? propagate(view, failure, predicted, on.tracker, on.window, on.propagation, on.navigation, on.report)
               : hold(view, failure, max_lost_frames, on.tracker, on.window, on.navigation, on.report);
  }

  /// Rigs without IMU: holds the last pose and tries up to `max_lost_frames` images against the last usable one.
  /// Repeated images and those of too little contrast do not count. Returns false when a reset is due.
  bool hold(const View<Sensors>& view, HealthReason failure, int max_lost_frames, const Tracker& tracker,
            Window& window, Nav& navigation, FrameReport& report) {
    const bool repeats = failure == HealthReason::images_repeat;
    const bool timed_out = !(tracker.outage_s(view.t_ns) < options_.max_imu_only_s);
    if (!repeats && (max_lost_frames == 0 || tracker.images().has_contrast())) ++lost_frames_;
    if (!repeats && (lost_frames_ > max_lost_frames || timed_out)) return false;
    inflate(view, tracker, navigation);
    if (!repeats) undo_frame(window);
    report.reason = failure;
    report.is_bridged = repeats && !timed_out;
    return true;
  }
  /// Inflates the covariance of a body that is not observed and may move.       docs/math/inertial_window.md (1f)
  void inflate(const View<Sensors>& view, const Tracker& tracker, Nav& navigation) const {
    if constexpr (!Propagation::has_imu_factors) {
      const CovarianceGrowth<S> growth{.rate_sigma = S(options_.lost_rate), .speed_sigma = S(options_.lost_speed)};
      const S outage_s = S(tracker.outage_s(view.t_ns));
      navigation.add_variance(growth.rotation_variance(outage_s, view.dt), growth.position_variance(outage_s, view.dt));
    }
  }

  /// Takes the predicted state x for the pose. Features of an image that shows enough are tracked and
  /// get depth by parallax, unless the pose contradicts the IMU; after max_outage_frames other images landmarks are
  /// detected again. Returns false when a reset is due and the image shows enough for it.
  bool propagate(const View<Sensors>& view, HealthReason failure, State x, Tracker& tracker, Window& window,
                 Propagation& propagation, Nav& navigation, FrameReport& report) {
    const bool repeats = failure == HealthReason::images_repeat;
    const bool contradicts_imu = failure == HealthReason::imu_disagrees;
    const bool is_stationary = hold_stationary(view.t_ns, tracker, window, propagation, x) && !contradicts_imu;
    auto covariance = navigation.covariance();  // a keyframe made during the outage does not reduce it
    if (!is_stationary) covariance = propagation.grown_covariance(covariance, S(tracker.outage_s(view.t_ns)));
    window.frames().set_latest(x);
    bool has_landmarks = !repeats && window.landmarks().seen_count() >= options_.min_landmarks;
    if (has_landmarks && !contradicts_imu) {
      tracker.images().keep(view, x.T_world_body);
      tracker.locate(view, window.frames(), window.landmarks());
    } else if (!repeats && !has_landmarks && ++lost_frames_ > options_.max_outage_frames &&
               window.restart_tracking(view, options_.min_landmarks, tracker, propagation, navigation)) {
      has_landmarks = true;
      lost_frames_ = 0;
    } else if (!repeats) {
      undo_frame(window);
    }
    window.accept_latest(propagation, navigation, report);
    navigation.set_covariance(covariance);
    report.tracked = 0;
    report.is_inconsistent = contradicts_imu;
    if (is_stationary) tracker.set_usable(view.t_ns);
    imu_only_s_ = is_stationary ? 0 : imu_only_s_ + double(view.dt);
    report.is_bridged = imu_only_s_ < options_.max_imu_only_s;
    report.reason = repeats || contradicts_imu ? failure : HealthReason::imu_only;
    return report.is_bridged || !has_landmarks;
  }

 private:
  /// Holds the pose of a slow body whose IMU is stationary: noise does not move it during an outage. The limit of the
  /// speed is the uncertainty of the velocity, velocity_sigma [m/s], and as much more for each second of the outage.
  bool hold_stationary(TimeNs t_ns, const Tracker& tracker, const Window& window, Propagation& propagation,
                       State& x) const {
    if constexpr (Propagation::Layout::template has<state::Velocity>) {
      const State& before = window.frames().latest();
      const double max_speed = velocity_sigma_ * (1 + tracker.outage_s(t_ns));
      if (!(double(norm(before.v_world_body)) < max_speed) || !propagation.can_be_stationary(t_ns)) return false;
      x.T_world_body = before.T_world_body;
      set_zero(x.v_world_body);
      return true;
    }
    return false;
  }
  static void undo_frame(Window& window) {
    window.landmarks().for_each([](auto& store) { store.undo_frame(); });
  }

  RecoveryOptions options_;
  double velocity_sigma_ = 0;  ///< of the predicted velocity [m/s]
  int lost_frames_ = 0;        ///< unusable frames in a row
  double imu_only_s_ = 0;      ///< time of IMU-only propagation, less that of usable frames since [s]
};

}  // namespace plumbline
