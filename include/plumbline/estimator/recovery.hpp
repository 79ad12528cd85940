#pragma once
/// When an image does not say where it was taken: the IMU bridges it, or the next ones are tried against the last good
/// one; then all begins anew where the body is thought to be.  docs/robustness.md

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

struct RecoveryOptions {
  int min_landmarks = 15;     ///< to begin with, or to go on with
  int max_lost_frames = 20;   ///< of a camera alone that show something, tried again before all begins anew
  double gap_s = 0.2;         ///< without an image of use: after it the camera may have turned by anything
  int max_blind_frames = 3;   ///< in a row that the IMU bridges, before new landmarks are looked for
  double max_coasting_s = 3;  ///< on the IMU alone, or waiting for a sight known, before all begins anew
  double lost_speed = 1;      ///< of a body that nothing tells of, sigma [m/s]
  double lost_rate = 1;       ///< [rad/s]
};

/// Without depth a new beginning takes as long again: it cannot wait as long for it.
template <SensorRig Sensors>
constexpr RecoveryOptions default_recovery() {
  return {.max_lost_frames = Sensors::has_depth ? 20 : 10};
}

template <class Odometry, class Beginning>
class Recovery {
 public:
  using Sensors = typename Odometry::Sensors;
  using S = typename Odometry::S;
  using State = typename Odometry::State;
  using Motion = typename Odometry::Motion;

  /// The first view of all; again: at the pose that is published.
  static void begin(Odometry& odometry, Beginning& beginning, const View<Sensors>& view) {
    if (!Motion::is_chain && odometry.estimate.resets > 0) {
      lose_place(odometry, view);
      beginning.lose_place(odometry);
    }
    beginning.take_first_view(odometry, view);
  }

  void recover(Odometry& odometry, Beginning& beginning, const View<Sensors>& view, const State& predicted,
               HealthReason lacks) {
    odometry.motion.lose();
    const int tries = beginning.patience(odometry.options.recovery.max_lost_frames);
    const bool goes_on =
        odometry.motion.carries_on() ? coast(odometry, view, predicted, lacks) : wait(odometry, view, tries, lacks);
    if (!goes_on) begin_anew(odometry, beginning, view);
  }
  void begin_anew(Odometry& odometry, Beginning& beginning, const View<Sensors>& view) {
    if (!Motion::is_chain || odometry.motion.carries_on()) {
      ++odometry.estimate.resets;
      beginning.lose_place(odometry);
    }
    lost_frames_ = 0;
    coasted_s_ = 0;
    begin(odometry, beginning, view);
  }
  /// What was lost is found again. Where that comes and goes readings and images do not belong together.
  void found_pose(Odometry& odometry, const View<Sensors>& view) {
    if (lost_frames_ > 0) odometry.motion.lose();
    lost_frames_ = 0;
    coasted_s_ = std::max(0.0, coasted_s_ - double(view.dt));
  }

 private:
  /// A camera alone tries its images against the last good one. What shows nothing, or the same again, is no try. False
  /// when all has to begin anew.
  bool wait(Odometry& odometry, const View<Sensors>& view, int tries, HealthReason lacks) {
    const bool hangs = lacks == HealthReason::images_repeat;
    const bool for_long = !(odometry.blind_s(view.t_ns) < odometry.options.recovery.max_coasting_s);
    if (!hangs && (tries == 0 || odometry.images.shows_something())) ++lost_frames_;
    if (!hangs && (lost_frames_ > tries || for_long)) return false;
    lose_place(odometry, view);
    if (!hangs) undo_frame(odometry);
    odometry.estimate.t_ns = view.t_ns;
    odometry.estimate.keyframe = false;
    odometry.estimate.tracked = 0;
    odometry.set_health(hangs && !for_long ? HealthState::degraded : HealthState::lost, lacks);
    return true;
  }
  /// A body that nothing tells of may move while it is not seen.
  static void lose_place(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (!Motion::is_chain) {
      const RecoveryOptions& options = odometry.options.recovery;
      const double until_s = odometry.blind_s(view.t_ns), since_s = until_s - double(view.dt);
      for (int k = 0; k < state::Pose::dim; ++k) {
        const double moving = k < 3 ? options.lost_rate : options.lost_speed;
        odometry.estimate.covariance(k, k) += S(moving * moving * (until_s * until_s - since_s * since_s));
      }
    }
  }

  /// The motion model alone. Where the image shows enough its features are followed, and located as soon as there is
  /// parallax; where it does not for long, what was seen before is out of sight. What contradicts the readings is of no
  /// use. False when all has to begin anew, and can.
  bool coast(Odometry& odometry, const View<Sensors>& view, State x, HealthReason lacks) {
    const RecoveryOptions& options = odometry.options.recovery;
    const bool is_old = lacks == HealthReason::images_repeat, is_wrong = lacks == HealthReason::imu_disagrees;
    const bool stands = stand(odometry, view.t_ns, x) && !is_wrong;  // else all may have to begin anew
    auto covariance = odometry.estimate.covariance;                  // a keyframe made on the way here knows no better
    if (!stands) covariance = odometry.motion.covariance_grown(covariance, S(odometry.blind_s(view.t_ns)));
    odometry.window().set_latest(x);
    bool shows_enough = !is_old && odometry.landmarks.seen_count() >= options.min_landmarks;
    if (shows_enough && !is_wrong) {
      odometry.images.keep(view, x.T_world_body);
      odometry.locate(view);
    } else if (!is_old && !shows_enough && ++lost_frames_ > options.max_blind_frames && look_anew(odometry, view)) {
      shows_enough = true;
      lost_frames_ = 0;
    } else if (!is_old) {
      undo_frame(odometry);
    }
    odometry.publish(view.t_ns);
    odometry.estimate.covariance = covariance;
    odometry.estimate.tracked = 0;
    if (stands) odometry.good_ns = view.t_ns;
    coasted_s_ = stands ? 0 : coasted_s_ + double(view.dt);
    const bool lost = !(coasted_s_ < options.max_coasting_s);
    odometry.set_health(lost ? HealthState::lost : HealthState::degraded,
                        is_old || is_wrong ? lacks : HealthReason::coasting);
    return !lost || !shows_enough;
  }
  /// A body that hardly moved stands when its readings say so: noise does not move it in the dark, and it is not lost.
  /// Every second there its velocity is in doubt by as much as it was before.
  static bool stand(Odometry& odometry, TimeNs t_ns, State& x) {
    if constexpr (Motion::Layout::template has<state::Velocity>) {
      const State& before = odometry.window().latest();
      const double hardly = odometry.options.motion.velocity_sigma * (1 + odometry.blind_s(t_ns));
      if (!(double(norm(before.v_world_body)) < hardly) || !odometry.motion.may_rest(t_ns)) return false;
      x.T_world_body = before.T_world_body;
      set_zero(x.v_world_body);
      return true;
    }
    return false;
  }
  /// What was seen before is out of sight: a keyframe at the latest state, if the image shows corners at all. The few
  /// that were followed here were too few to agree on anything, and must not tie it.
  static bool look_anew(Odometry& odometry, const View<Sensors>& view) {
    odometry.drop_temporary();
    odometry.landmarks.for_each([](auto& store) { store.lose_sight(); });
    const int slot =
        odometry.backend.insert(view.t_ns, odometry.window().latest(), odometry.motion.link(odometry.keyframe()));
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

  int lost_frames_ = 0;   ///< in a row whose image was of no use
  double coasted_s_ = 0;  ///< on the motion model alone, more than was tracked since
};

}  // namespace plumbline
