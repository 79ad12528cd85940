#pragma once
/// From nothing to a map and, with an IMU, to metres: drives a start (start/) with what the odometry sees.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/reckoned_place.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/start/settling.hpp"
#include "plumbline/start/start_report.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class Odometry, class StartT>
class Beginning {
 public:
  using Start = StartT;
  using Sensors = typename Odometry::Sensors;
  using S = typename Odometry::S;
  using State = typename Odometry::State;

  explicit Beginning(const typename Odometry::Options& options) : start_(options.start), place_(options) {
    if constexpr (settles) settling_ = Settling(options.start.settling);
  }

  const InitReport& report() const { return report_; }
  bool has_seen_a_frame() const { return stage_ != Stage::nothing; }
  bool has_first_view() const { return stage_ == Stage::one_view || has_map(); }
  bool has_map() const { return stage_ == Stage::map; }

  /// The scale of a camera without depth is uncertain for some time.
  void settle(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (settles) {
      if (report_.stage != InitStage::done) return;
      const Health health = odometry.estimate.health;
      settling_.see(seconds_between(report_.done_ns, view.t_ns), double(view.dt),
                    health.reason == HealthReason::imu_disagrees, odometry.motion.speed(),
                    odometry.motion.speed_sigma());
      if (!settling_.is_certain() && health.state == HealthState::tracking)
        odometry.set_health(HealthState::degraded, HealthReason::scale_uncertain);
    }
  }
  /// Whether the start was none, as readings and images contradicted each other ever since.
  bool is_refuted() const {
    if constexpr (settles)
      return report_.stage == InitStage::done && settling_.is_refuted();
    else
      return false;
  }

  /// Frames without a pose, after which all begins anew. Poses are aligned with readings in an unbroken series.
  int patience(int max_lost_frames) const { return is_complete ? max_lost_frames : 0; }

  /// Until there are poses that are tied together the readings alone lead on from the last one that was published.
  void reckon(const Odometry& odometry, const View<Sensors>& view) { place_.advance(odometry, view); }
  /// All begins anew: of the body no more is known than what is published, and not how fast it moves.
  void lose_place(Odometry& odometry) {
    if constexpr (settles) {
      if (is_refuted()) {
        ++report_.rejected;
        place_.forget_way(odometry, first_view_ns_, start_.options().gyro_bias_sigma);
      }
    }
    place_.lose(odometry);
  }

  /// The first keyframe of all, or of what begins anew where the body is thought to be.
  void take_first_view(Odometry& odometry, const View<Sensors>& view) {
    place_.begin_anew(odometry);
    stage_ = Stage::blind;
    report_ = {.rejected = report_.rejected};
    const int slot = odometry.begin_anew(view, odometry.motion.restart(odometry.window().latest()));
    Estimate<S>& estimate = odometry.estimate;
    estimate.t_ns = view.t_ns;
    estimate.tracked = 0;
    estimate.keyframe = false;
    report_.features = odometry.landmarks.seen_count();
    const int usable = is_complete && !Start::needs_second_view ? odometry.landmarks.tracked_count() : report_.features;
    const int needed = odometry.options.recovery.min_landmarks;
    if (usable < needed) {
      const bool shows_enough = report_.features >= needed;
      wait(odometry, shows_enough ? HealthReason::no_depth : HealthReason::few_features, InitStage::few_features);
      return;
    }
    first_view_ns_ = view.t_ns;
    stage_ = Start::needs_second_view ? Stage::one_view : Stage::map;
    if constexpr (is_complete && !Start::needs_second_view) {
      finish(view);
      odometry.publish(view.t_ns);
    }
    odometry.adopt_keyframe(view, slot);
    if constexpr (!is_complete || Start::needs_second_view)
      wait(odometry, HealthReason::aligning,
           Start::needs_second_view ? InitStage::little_parallax : InitStage::aligning);
    begin_series(odometry, view);
  }

  /// Follows the corners of the first view until a second one sees them from far enough aside.
  void look_for_second_view(Odometry& odometry, const View<Sensors>& view, const State& predicted) {
    if constexpr (Start::needs_second_view) {
      auto& start = start_.visual();
      const SE3<S> T_world_first = odometry.window().T_world_body(odometry.keyframe());
      State x = predicted;
      x.T_world_body = SE3<S>(predicted.T_world_body.rotation(), T_world_first.p());
      odometry.front_ends.follow(view, odometry.window(), odometry.landmarks, x.T_world_body);
      odometry.window().set_latest(x);
      odometry.images.keep(view, x.T_world_body);
      odometry.estimate.t_ns = odometry.good_ns = view.t_ns;
      start.clear_pairs();
      odometry.front_ends.for_each_pair(view, odometry.landmarks, odometry.keyframe(),
                                        [&](const Vec<S, 3>& f1, const Vec<S, 3>& f2) { start.add_pair(f1, f2); });
      odometry.landmarks.for_each([](auto& store) { store.prune(); });
      report_.features = start.pairs();
      wait(odometry, HealthReason::aligning, InitStage::little_parallax);
      const double motion_px = odometry.motion_of_most_px();
      const bool at_rest = is_at_rest(odometry, view.t_ns, motion_px);
      if (start.has_expired(seconds_between(first_view_ns_, view.t_ns)) ||
          (at_rest ? has_crept(odometry, motion_px) : look_for_halt(odometry, view.t_ns, motion_px))) {
        take_first_view(odometry, view);
      }
      if (at_rest) rest(odometry);
      if (at_rest || first_view_ns_ == view.t_ns || !has_first_view()) return;
      const SO3<S> R_world_first = T_world_first.rotation() * view.T_body_cam.rotation();
      const SO3<S> R_2_1 = (x.T_world_body.rotation() * view.T_body_cam.rotation()).inverse() * R_world_first;
      if (!start.solve(R_2_1, report_)) return;
      x.T_world_body = T_world_first * view.T_body_cam * start.T_1_2() * view.T_body_cam.inverse();
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
      begin_series(odometry, view);
    }
  }

  /// One frame of a map that is not metric yet: a pose for the alignment, known that well by its image. True when it is
  /// worth trying; the frame becomes a keyframe first.
  bool gather(Odometry& odometry, const View<Sensors>& view, const typename Odometry::Covariance& covariance) {
    if constexpr (is_complete) {
      // Points that are there for the start alone go when the others carry the estimate.
      if (odometry.front_ends.lasting_count(odometry.landmarks) >= 2 * odometry.options.recovery.min_landmarks) {
        odometry.front_ends.end_start(odometry.landmarks);
      }
      return false;
    } else {
      publish_rough(odometry);
      return start_.add(view.t_ns, odometry.window().latest().T_world_body * view.T_body_cam,
                        odometry.noise_of_place(covariance), odometry.motion.imu().since_frame(), odometry.rig_state);
    }
  }
  /// Vision and IMU agree, perhaps: then the map becomes metric.
  void align(Odometry& odometry, const View<Sensors>& view) {
    if constexpr (!is_complete) {
      const SE3<S>& T_body_cam = odometry.rig_state.T_body_cam();
      const auto& window = odometry.window();
      for (int slot = 0; slot < window.slots; ++slot) {
        if (window[slot].used) start_.correct(window[slot].t_ns, window.T_world_body(slot) * view.T_body_cam);
      }
      if (!start_.align(T_body_cam, odometry.options.motion.gravity, report_) ||
          !start_.is_in_time(odometry.motion.camera_imu(), seconds_between(first_view_ns_, view.t_ns)))
        return start_.is_contradicted() ? give_up(odometry, view) : publish_rough(odometry);
      const State before = odometry.window().latest();
      odometry.landmarks.for_each([&](auto& store) { store.rescale(start_.scale()); });
      begin_window(odometry, [&](int slot) { return place_.state_of(start_, window.T_world_body(slot), T_body_cam); });
      const double length = length_of(window);
      solve(odometry, length);
      // Once more: what is believed from now on was linearized where that ended, not at what the alignment had guessed.
      begin_window(odometry, [&](int slot) { return window[slot].state.value(); });
      solve(odometry, length);
      const State x = odometry.window().latest();
      const bool in_time = start_.judge_clock(window.time_offset_s(odometry.rig_state.time_offset_s()));
      if (!in_time) odometry.motion.believe_clock_of(window);
      if (!in_time || !start_.believes(x)) {
        odometry.window().set_latest(before);
        return give_up(odometry, view);
      }
      odometry.motion.become_metric();
      place_.become_metric(odometry, start_);
      finish(view);
      odometry.become_metric(view);
    }
  }

 private:
  enum class Stage : std::uint8_t { nothing, blind, one_view, map };
  /// Whether a map is all that is needed.
  static constexpr bool is_complete = !Odometry::Motion::is_chain;
  /// Whether its scale is one that images and readings find together.
  static constexpr bool settles = !is_complete && Start::needs_second_view;

  void wait(Odometry& odometry, HealthReason reason, InitStage stage) {
    report_.stage = stage;
    odometry.set_health(odometry.estimate.resets > 0 ? HealthState::lost : HealthState::initializing, reason);
    place_.publish(odometry);
  }
  /// What was gathered does not fit together.
  void give_up(Odometry& odometry, const View<Sensors>& view) {
    ++report_.rejected;
    take_first_view(odometry, view);
    report_.stage = InitStage::not_believed;
  }
  void finish(const View<Sensors>& view) {
    report_.stage = InitStage::done;
    report_.done_ns = view.t_ns;
    if constexpr (settles) settling_.begin();
  }

  void begin_series(Odometry& odometry, const View<Sensors>& view) {
    odometry.good_ns = view.t_ns;
    if constexpr (!is_complete) {
      start_.clear();
      start_.add(view.t_ns, odometry.window().latest().T_world_body * view.T_body_cam, zeros<Mat<S, 3, 3>>(),
                 odometry.motion.imu().since(odometry.window().latest()), odometry.rig_state);
    }
  }

  void publish_rough(Odometry& odometry) {
    wait(odometry, HealthReason::aligning, InitStage::aligning);
    if (start_.has_estimate()) place_.publish_rough(odometry, start_);
  }
  /// The frames' links hold from now on, nothing is known but what the alignment knew of the biases.
  void begin_window(Odometry& odometry, auto&& state_of) {
    odometry.backend.restart(state_of, start_.prior_on_biases(), odometry.rig_state.T_body_cam(),
                             odometry.motion.clock(start_.options().max_time_sigma_s));
  }
  static double length_of(const auto& window) {
    return double(norm(window.T_world_body(window.newest()).p() - window.T_world_body(window.oldest()).p()));
  }
  /// What the alignment knows of the scale, the window alone might not: by it oldest and newest frame are `length` [m]
  /// apart. Its poses have errors in common, so not too tight.
  void solve(Odometry& odometry, double length) {
    const auto& window = odometry.window();
    if constexpr (Start::needs_second_view) {
      const auto& options = start_.options();
      const double noise = options.alignment.position_sigma * double(start_.scale());
      const double sigma = std::hypot(std::max(start_.scale_sigma(), options.min_scale_sigma) * length, noise);
      if (window.size() > 1) odometry.backend.hold_distance(window.oldest(), window.newest(), length, sigma);
    }
    LevenbergMarquardtOptions solver = odometry.options.backend.solver;
    solver.max_iterations *= 2;
    odometry.backend.optimize(odometry.rig, odometry.rig_state.T_body_cam(), odometry.landmarks, solver);
  }

  static bool is_at_rest(Odometry& odometry, TimeNs t_ns, double motion_px) {
    if constexpr (is_complete)
      return false;
    else
      return odometry.motion.look_for_rest(t_ns, motion_px);
  }
  /// Tracks creep by themselves: before that looks like motion, the first view is taken again.
  static bool has_crept(const Odometry& odometry, double motion_px) {
    if constexpr (is_complete)
      return false;
    else
      return motion_px > odometry.options.motion.rest_motion_px;
  }
  /// What is seen has not moved any more for a while, nor do the readings: a body that stopped after its first view,
  /// and stands still against a later one.
  bool look_for_halt(Odometry& odometry, TimeNs t_ns, double motion_px) {
    if constexpr (is_complete) {
      return false;
    } else {
      const auto& options = odometry.options.motion;
      if (!(std::abs(motion_px - stopped_px_) < options.rest_motion_px)) {
        stopped_px_ = motion_px;
        stopped_ns_ = t_ns;
      }
      return seconds_between(stopped_ns_, t_ns) > options.rest_check_s && odometry.motion.may_rest(t_ns);
    }
  }
  void rest(Odometry& odometry) {
    if constexpr (!is_complete) place_.publish_rest(odometry, start_.options().accel_bias_sigma);
  }

  struct Nothing {};
  using Place = std::conditional_t<is_complete, HeldPlace<Odometry, Start>, ReckonedPlace<Odometry, Start>>;
  using ScaleSettling = std::conditional_t<settles, Settling, Nothing>;

  Start start_;
  [[no_unique_address]] Place place_;
  [[no_unique_address]] ScaleSettling settling_;
  Stage stage_ = Stage::nothing;
  TimeNs first_view_ns_ = 0;
  TimeNs stopped_ns_ = 0;  ///< since then what is seen
  double stopped_px_ = 0;  ///< has been that far from the first view
  InitReport report_;
};

}  // namespace plumbline
