#pragma once
/// The pose that is published until initialization is complete: the stationary pose, the dead-reckoned pose, or the
/// up-to-scale pose with the present estimate of the scale. A reset continues from it.
///                                                                               docs/math/initialization.md (9)

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/motion/dead_reckoning.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

/// The published pose of a rig without IMU: the last one is held, a reset starts from it.
template <class Odometry, class Initializer>
class HoldLastPose {
 public:
  explicit HoldLastPose(const typename Odometry::Options&) {}
  void advance(const Odometry&, const View<typename Odometry::Sensors>&) {}
  void mark_lost(Odometry& odometry) {
    odometry.world_uncertainty.set(odometry.estimate.T_world_body, odometry.estimate.covariance);
  }
  void reset(Odometry&) {}
  void publish(Odometry&) const {}
};

template <class Odometry, class Initializer>
class DeadReckonedPose {
 public:
  using S = typename Odometry::S;
  using State = typename Odometry::State;
  using Covariance = typename Odometry::Covariance;

  explicit DeadReckonedPose(const typename Odometry::Options& options)
      : dead_reckoning_({.max_s = options.recovery.max_imu_only_s,
                         .velocity_walk = options.motion.velocity_sigma,
                         .lost_speed = options.recovery.lost_speed,
                         .lost_rate = options.recovery.lost_rate}) {}

  /// Propagates the pose by the IMU increment since the last frame, until initialization is complete.
  void advance(const Odometry& odometry, const View<typename Odometry::Sensors>& view) {
    if (odometry.motion.is_initialized()) return;
    const auto& imu = odometry.motion.imu();
    dead_reckoning_.advance(imu.since_frame().increment(), gravity(odometry), view.dt, imu.is_unusable(),
                            imu.is_missing());
  }
  /// Continues from the published pose and covariance, with unknown velocity.
  void mark_lost(Odometry& odometry) {
    propagate_from(odometry, odometry.window().latest(), 0);
    dead_reckoning_.mark_lost();
  }
  /// Adds the uncertainty of the path since `since_ns` to the published covariance, and restores the biases that the
  /// state had when initialization was completed. For a rejected initialization, whose path and biases are wrong.
  ///   sigma_p = hypot(distance from the initial pose, lost_speed * s),   sigma_heading = gyro_bias_sigma * s
  /// with s the time since `since_ns` [s] and gyro_bias_sigma in [rad/s].
  void discard_path(Odometry& odometry, TimeNs since_ns, double gyro_bias_sigma) const {
    State x = odometry.window().latest();
    x.bias_gyro = initial_state_.bias_gyro;
    x.bias_accel = initial_state_.bias_accel;
    odometry.window().set_latest(x);
    Estimate<S>& estimate = odometry.estimate;
    const double s = seconds_between(since_ns, estimate.t_ns);
    const S position_sigma = S(std::hypot(traveled(estimate.T_world_body), odometry.options.recovery.lost_speed * s));
    const S heading_sigma = S(gyro_bias_sigma * s);
    for (int k = 0; k < 3; ++k) {
      estimate.covariance(k, k) += heading_sigma * heading_sigma;
      estimate.covariance(3 + k, 3 + k) += position_sigma * position_sigma;
    }
  }

  /// Sets the initial pose of a new initialization: the dead-reckoned position and heading, with their covariance.
  void reset(Odometry& odometry) {
    if (!dead_reckoning_.has_begun() || (odometry.motion.is_stationary() && !dead_reckoning_.is_lost())) return;
    const SE3<S>& T = dead_reckoning_.state().T_world_body;
    const Vec<S, 3> g = T.rotation().inverse() * gravity(odometry);
    T_world_initial_ = SE3<S>(T.rotation() * upright<S>(g).inverse(), T.p());
    odometry.world_uncertainty.set(T, position_and_heading(dead_reckoning_.covariance(), T.rotation()));
    odometry.estimate.resets += dead_reckoning_.count_loss();
  }
  /// The state in the published world of a body that vision has at T_ref_rotated, see InertialInitializer::state_of.
  State state_of(const Initializer& initializer, const SE3<S>& T_ref_rotated, const SE3<S>& T_body_cam) const {
    State x = initializer.state_of(T_ref_rotated, T_body_cam);
    x.T_world_body = T_world_initial_ * x.T_world_body;
    return x;
  }
  /// Initialization is complete: the poses of the window are metric and upright.
  void set_initialized(Odometry& odometry, const Initializer& initializer) {
    initial_state_ = odometry.window().latest();
    const SE3<S>& T = odometry.window().T_world_body(odometry.window().oldest());
    odometry.world_uncertainty.restart_path(T);  // the path is metric and upright from here on
    if constexpr (Initializer::needs_second_view) {
      // The path so far has the relative error of the scale. Its heading is about an axis that is tilted by
      // gravity_sigma, of which half is taken for the error of the angle.
      odometry.world_uncertainty.add_uncertainty(T, S(initializer.scale_sigma() * traveled(T)),
                                                 S(0.5 * initializer.gravity_sigma()));
    }
  }

  /// Publishes the dead-reckoned pose, if there is one.
  void publish(Odometry& odometry) const {
    if (!dead_reckoning_.has_begun()) return;
    set_estimate(odometry, dead_reckoning_.state());
    odometry.estimate.covariance = dead_reckoning_.covariance();
  }
  /// Publishes the up-to-scale pose in meters by the present scale, unless dead reckoning is more accurate.
  void publish_up_to_scale(Odometry& odometry, const Initializer& initializer) {
    State x = state_of(initializer, odometry.window().latest().T_world_body, odometry.rig_state.T_body_cam());
    x.v_world_body = T_world_initial_.rotation() * initializer.latest_velocity();
    const auto& motion = odometry.options.motion;
    const double position_sigma =
        initializer.scale_sigma() * traveled(x.T_world_body) + motion.stationary_position_sigma;
    if (dead_reckoning_.is_preferred_to(x.T_world_body.p(), S(position_sigma))) return;
    publish(odometry, x, initializer.gravity_sigma(), position_sigma);
    odometry.set_health(HealthState::degraded, HealthReason::scale_uncertain);
    // After a rest the stationary pose stays the base of the propagation: the map may still be rejected.
    if (was_stationary_ && !dead_reckoning_.is_lost()) return;
    was_stationary_ = false;
    propagate_from(odometry, x, initializer.scale_sigma() * double(norm(x.v_world_body)) + motion.velocity_sigma);
  }
  /// Publishes the stationary pose: tilt, biases and zero velocity are determined, in the world frame that
  /// InertialInitializer gives to the window.
  void publish_stationary(Odometry& odometry, double accel_bias_sigma) {
    State stationary = odometry.motion.stationary_state(), x = odometry.window().latest();
    x.bias_gyro = stationary.bias_gyro;
    x.bias_accel = stationary.bias_accel;
    odometry.window().set_latest(x);
    stationary.T_world_body = T_world_initial_ * stationary.T_world_body;
    const auto& motion = odometry.options.motion;
    publish(odometry, stationary, accel_bias_sigma / motion.gravity, motion.stationary_position_sigma);
    was_stationary_ = true;
    propagate_from(odometry, stationary, motion.velocity_sigma);  // departure is detected only once there is some speed
    odometry.set_health(HealthState::degraded, HealthReason::aligning);
  }

 private:
  static Vec<S, 3> gravity(const Odometry& odometry) { return gravity_in_world<S>(S(odometry.options.motion.gravity)); }
  double traveled(const SE3<S>& T) const { return double(norm(T.p() - T_world_initial_.p())); }
  /// Starts dead reckoning at x, with the published covariance and velocity_sigma [m/s].
  void propagate_from(const Odometry& odometry, const State& x, double velocity_sigma) {
    dead_reckoning_.begin(x, odometry.estimate.covariance, S(velocity_sigma));
  }
  /// Publishes a state with the sigmas of its tilt [rad] and position [m].
  static void publish(Odometry& odometry, const State& x, double tilt_sigma, double position_sigma) {
    set_estimate(odometry, x);
    Covariance P = zeros<Covariance>();
    for (int k = 0; k < 3; ++k) {
      P(k, k) = S(tilt_sigma * tilt_sigma);
      P(3 + k, 3 + k) = S(position_sigma * position_sigma);
    }
    odometry.publish(P);
  }
  static void set_estimate(Odometry& odometry, const State& x) {
    Estimate<S>& estimate = odometry.estimate;
    estimate.T_world_body = x.T_world_body;
    estimate.v_world_body = x.v_world_body;
    estimate.bias_gyro = x.bias_gyro;
    estimate.bias_accel = x.bias_accel;
  }

  DeadReckoning<S> dead_reckoning_;
  SE3<S> T_world_initial_;       ///< pose at the start of this initialization, upright
  State initial_state_;          ///< latest state when initialization was completed
  bool was_stationary_ = false;  ///< dead reckoning started from a stationary pose
};

}  // namespace plumbline
