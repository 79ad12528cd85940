#pragma once
/// What is published while the poses of a start are not tied together yet: where the body stood, where its readings
/// have led since, where poses of a rough scale say it is. All begins anew there.    docs/math/initialization.md (9)

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/motion/dead_reckoning.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/origin.hpp"

namespace plumbline {

/// Of a camera alone: nothing leads on from what was published last.
template <class Odometry, class Start>
class HeldPlace {
 public:
  explicit HeldPlace(const typename Odometry::Options&) {}
  void advance(const Odometry&, const View<typename Odometry::Sensors>&) {}
  void lose(Odometry& odometry) { odometry.origin.set(odometry.estimate.T_world_body, odometry.estimate.covariance); }
  void begin_anew(Odometry&) {}
  void publish(Odometry&) const {}
};

template <class Odometry, class Start>
class ReckonedPlace {
 public:
  using S = typename Odometry::S;
  using State = typename Odometry::State;
  using Covariance = typename Odometry::Covariance;

  explicit ReckonedPlace(const typename Odometry::Options& options)
      : reckoning_({.max_s = options.recovery.max_coasting_s,
                    .velocity_walk = options.motion.velocity_sigma,
                    .lost_speed = options.recovery.lost_speed,
                    .lost_rate = options.recovery.lost_rate}) {}

  /// By the readings since the last frame, until there are poses that are tied together.
  void advance(const Odometry& odometry, const View<typename Odometry::Sensors>& view) {
    if (odometry.motion.is_metric()) return;
    const auto& imu = odometry.motion.imu();
    reckoning_.advance(imu.since_frame().increment(), gravity(odometry), view.dt, imu.blind(), imu.missing());
  }
  /// No more is known than what is published, and not how fast the body moves.
  void lose(Odometry& odometry) {
    lead_on(odometry, odometry.window().latest(), 0);
    reckoning_.lose();
  }
  /// What a wrong map made of the way since `since_ns`, and of the biases, says nothing: the body may be anywhere, its
  /// heading is that of the gyroscope, whose bias has a sigma [rad/s].
  void forget_way(Odometry& odometry, TimeNs since_ns, double gyro_bias_sigma) const {
    State x = odometry.window().latest();
    x.bias_gyro = begun_.bias_gyro;
    x.bias_accel = begun_.bias_accel;
    odometry.window().set_latest(x);
    Estimate<S>& estimate = odometry.estimate;
    const double s = seconds_between(since_ns, estimate.t_ns);
    const S place_sigma = S(std::hypot(travelled(estimate.T_world_body), odometry.options.recovery.lost_speed * s));
    const S heading_sigma = S(gyro_bias_sigma * s);
    for (int k = 0; k < 3; ++k) {
      estimate.covariance(k, k) += heading_sigma * heading_sigma;
      estimate.covariance(3 + k, 3 + k) += place_sigma * place_sigma;
    }
  }

  /// What is seen from now on is at the place and heading to which the readings have led, and knows no more of them.
  void begin_anew(Odometry& odometry) {
    if (!reckoning_.has_begun() || (odometry.motion.at_rest() && !reckoning_.is_lost())) return;
    const SE3<S>& T = reckoning_.state().T_world_body;
    const Vec<S, 3> g = T.rotation().inverse() * gravity(odometry);
    T_world_start_ = SE3<S>(T.rotation() * upright<S>(g).inverse(), T.p());
    odometry.origin.set(T, place_and_heading(reckoning_.covariance(), T.rotation()));
    odometry.estimate.resets += reckoning_.count_loss();
  }
  /// In the world that is published: what vision has at T_ref_turned.
  State state_of(const Start& start, const SE3<S>& T_ref_turned, const SE3<S>& T_body_cam) const {
    State x = start.state_of(T_ref_turned, T_body_cam);
    x.T_world_body = T_world_start_ * x.T_world_body;
    return x;
  }
  /// The window has become metric.
  void become_metric(Odometry& odometry, const Start& start) {
    begun_ = odometry.window().latest();
    const SE3<S>& T = odometry.window().T_world_body(odometry.window().oldest());
    odometry.origin.begin_way(T);  // in metres, and upright
    if constexpr (Start::needs_second_view) {
      // On the way here scale and vertical were what they were taken for; the heading's axis is tilted, say half way.
      odometry.origin.doubt(T, S(start.scale_sigma() * travelled(T)), S(0.5 * start.gravity_sigma()));
    }
  }

  /// To where the readings have led, if from anywhere.
  void publish(Odometry& odometry) const {
    if (!reckoning_.has_begun()) return;
    show(odometry, reckoning_.state());
    odometry.estimate.covariance = reckoning_.covariance();
  }
  /// Before the scale is certain: the pose in the metres that are known so far, if the readings do not know better.
  void publish_rough(Odometry& odometry, const Start& start) {
    State x = state_of(start, odometry.window().latest().T_world_body, odometry.rig_state.T_body_cam());
    x.v_world_body = T_world_start_.rotation() * start.latest_velocity();
    const auto& motion = odometry.options.motion;
    const double place_sigma = start.scale_sigma() * travelled(x.T_world_body) + motion.rest_position_sigma;
    if (reckoning_.outweighs(x.T_world_body.p(), S(place_sigma))) return;
    publish(odometry, x, start.gravity_sigma(), place_sigma);
    odometry.set_health(HealthState::degraded, HealthReason::scale_uncertain);
    if (stood_ && !reckoning_.is_lost()) return;  // a map may yet be found wrong, a rest is none
    stood_ = false;
    lead_on(odometry, x, start.scale_sigma() * double(norm(x.v_world_body)) + motion.velocity_sigma);
  }
  /// Standing still: all is known but the scale of what is seen. The world is the one that the window will have, see
  /// InertialStart.
  void publish_rest(Odometry& odometry, double accel_bias_sigma) {
    State known = odometry.motion.state_at_rest(), x = odometry.window().latest();
    x.bias_gyro = known.bias_gyro;
    x.bias_accel = known.bias_accel;
    odometry.window().set_latest(x);
    known.T_world_body = T_world_start_ * known.T_world_body;
    const auto& motion = odometry.options.motion;
    publish(odometry, known, accel_bias_sigma / motion.gravity, motion.rest_position_sigma);
    stood_ = true;
    lead_on(odometry, known, motion.velocity_sigma);  // that it leaves is seen when it has some speed already
    odometry.set_health(HealthState::degraded, HealthReason::aligning);
  }

 private:
  static Vec<S, 3> gravity(const Odometry& odometry) { return gravity_in_world<S>(S(odometry.options.motion.gravity)); }
  double travelled(const SE3<S>& T) const { return double(norm(T.p() - T_world_start_.p())); }
  /// From what is published; velocity_sigma [m/s].
  void lead_on(const Odometry& odometry, const State& x, double velocity_sigma) {
    reckoning_.begin(x, odometry.estimate.covariance, S(velocity_sigma));
  }
  /// A state whose vertical [rad] and place [m] are known that well.
  static void publish(Odometry& odometry, const State& x, double tilt_sigma, double place_sigma) {
    show(odometry, x);
    Covariance P = zeros<Covariance>();
    for (int k = 0; k < 3; ++k) {
      P(k, k) = S(tilt_sigma * tilt_sigma);
      P(3 + k, 3 + k) = S(place_sigma * place_sigma);
    }
    odometry.publish(P);
  }
  static void show(Odometry& odometry, const State& x) {
    Estimate<S>& estimate = odometry.estimate;
    estimate.T_world_body = x.T_world_body;
    estimate.v_world_body = x.v_world_body;
    estimate.bias_gyro = x.bias_gyro;
    estimate.bias_accel = x.bias_accel;
  }

  DeadReckoning<S> reckoning_;
  SE3<S> T_world_start_;  ///< where all began anew, upright
  State begun_;           ///< with which it became metric
  bool stood_ = false;    ///< it leads on from a rest
};

}  // namespace plumbline
