#pragma once
/// The navigation state until initialization is complete: the stationary pose, the dead-reckoned pose, or the
/// up-to-scale pose with the present estimate of the scale. A reset continues from it.
///                                                                               docs/math/initialization.md (9)

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/propagation/dead_reckoning.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

/// The same of a rig without IMU: the last pose is held, and a reset starts from it.
template <class S>
struct HoldLastPose {
  explicit HoldLastPose(const auto& /*options*/) {}
  static void advance(const auto& /*propagation*/, S /*dt*/) {}
  static void mark_lost(const auto& /*x*/, auto& navigation) {
    navigation.world().set(navigation.T_world_body(), navigation.covariance());
  }
  static bool reset(bool /*is_stationary*/, auto& /*navigation*/) { return false; }
  static void apply(auto& /*navigation*/) {}
};

template <class S>
class DeadReckonedPose {
 public:
  using State = NavState<S>;
  using Covariance = Mat<S, 6, 6>;

  explicit DeadReckonedPose(const auto& options)
      : options_({.max_s = options.recovery.max_imu_only_s,
                  .velocity_walk = options.propagation.velocity_sigma,
                  .lost_speed = options.recovery.lost_speed,
                  .lost_rate = options.recovery.lost_rate}),
        gravity_(options.propagation.gravity),
        velocity_sigma_(options.propagation.velocity_sigma),
        position_sigma_(options.propagation.stationary_position_sigma),
        dead_reckoning_(options_) {}

  /// Propagates the pose by the IMU increment since the last frame, until initialization is complete.
  void advance(const auto& propagation, S dt) {
    if (propagation.is_initialized()) return;
    const auto& imu = propagation.imu();
    dead_reckoning_.advance(imu.since_frame().increment(), gravity_in_world<S>(S(gravity_)), dt, imu.is_unusable(),
                            imu.is_missing());
  }
  /// Continues from the state x with the covariance of the navigation state, and with unknown velocity.
  void mark_lost(const State& x, const auto& navigation) {
    dead_reckoning_.begin(x, navigation.covariance(), S(0));
    dead_reckoning_.mark_lost();
  }
  /// Adds the uncertainty of the path since `since_ns` to the covariance, and restores the biases that the state had
  /// when initialization was completed. For a rejected initialization, whose path and biases are wrong.
  ///   sigma_p = hypot(distance from the initial pose, lost_speed * s),   sigma_heading = gyro_bias_sigma * s
  /// with s the time since `since_ns` [s] and gyro_bias_sigma in [rad/s].
  void discard_path(auto& window, auto& navigation, TimeNs since_ns, double gyro_bias_sigma) const {
    State x = window.latest();
    x.bias_gyro = initial_state_.bias_gyro;
    x.bias_accel = initial_state_.bias_accel;
    window.set_latest(x);
    const double s = seconds_between(since_ns, navigation.t_ns());
    const S position_sigma = S(elementary::hypot(traveled(navigation.T_world_body()), options_.lost_speed * s));
    const S heading_sigma = S(gyro_bias_sigma * s);
    navigation.add_variance(heading_sigma * heading_sigma, position_sigma * position_sigma);
  }

  /// Sets the initial pose of a new initialization: the dead-reckoned position and heading, with their covariance. True
  /// when the pose was lost since the last call.
  bool reset(bool is_stationary, auto& navigation) {
    if (!dead_reckoning_.has_begun() || (is_stationary && !dead_reckoning_.is_lost())) return false;
    const SE3<S>& T = dead_reckoning_.state().T_world_body;
    const Vec<S, 3> g = T.rotation().inverse() * gravity_in_world<S>(S(gravity_));
    T_world_initial_ = SE3<S>(T.rotation() * upright<S>(g).inverse(), T.p());
    navigation.world().set(T, position_and_heading(dead_reckoning_.covariance(), T.rotation()));
    return dead_reckoning_.count_loss();
  }
  /// The state in the world of the navigation of a body that vision has at T_ref_rotated, see
  /// InertialInitializer::state_of.
  State state_of(const auto& initializer, const SE3<S>& T_ref_rotated, const SE3<S>& T_body_cam) const {
    State x = initializer.state_of(T_ref_rotated, T_body_cam);
    x.T_world_body = T_world_initial_ * x.T_world_body;
    return x;
  }
  /// From coordinates of vision to those of the world of the navigation: x_world = S x_vision, by which state_of maps
  /// the camera.
  Sim3<S> similarity(const auto& initializer, const SE3<S>& T_body_cam) const {
    const State origin = state_of(initializer, SE3<S>(), T_body_cam);
    const SE3<S> T_world_cam = origin.T_world_body * T_body_cam;
    return Sim3<S>(initializer.scale(), T_world_cam.rotation() * T_body_cam.rotation().inverse(), T_world_cam.p());
  }
  /// Initialization is complete: the poses of the window are metric and upright.
  template <class Initializer>
  void set_initialized(const auto& window, const Initializer& initializer, auto& navigation) {
    initial_state_ = window.latest();
    const SE3<S>& T = window.T_world_body(window.oldest());
    navigation.world().restart_path(T);  // the path is metric and upright from here on
    if constexpr (Initializer::needs_second_view) {
      // The path so far has the relative error of the scale, and a heading about an axis that is tilted by
      // gravity_sigma; half of gravity_sigma is taken for its angle; tuned: docs/decisions/132 (chosen).
      constexpr double heading_per_tilt = 0.5;
      navigation.world().add_uncertainty(T, S(initializer.scale_sigma() * traveled(T)),
                                         S(heading_per_tilt * initializer.gravity_sigma()));
    }
  }

  /// Sets the dead-reckoned pose, if there is one.
  void apply(auto& navigation) const {
    if (!dead_reckoning_.has_begun()) return;
    navigation.set_state(dead_reckoning_.state());
    navigation.set_covariance(dead_reckoning_.covariance());
  }
  /// Sets the up-to-scale pose T_ref_rotated in meters by the present scale, unless dead reckoning is more accurate.
  /// Returns whether it did.
  bool apply_up_to_scale(const auto& initializer, const SE3<S>& T_ref_rotated, const SE3<S>& T_body_cam,
                         auto& navigation) {
    State x = state_of(initializer, T_ref_rotated, T_body_cam);
    x.v_world_body = T_world_initial_.rotation() * initializer.latest_velocity();
    const double position_sigma = initializer.scale_sigma() * traveled(x.T_world_body) + position_sigma_;
    if (dead_reckoning_.is_preferred_to(x.T_world_body.p(), S(position_sigma))) return false;
    apply(x, initializer.gravity_sigma(), position_sigma, navigation);
    // After a rest the stationary pose stays the base of the propagation: the landmarks may still be rejected.
    if (was_stationary_ && !dead_reckoning_.is_lost()) return true;
    was_stationary_ = false;
    dead_reckoning_.begin(x, navigation.covariance(),
                          S(initializer.scale_sigma() * double(norm(x.v_world_body)) + velocity_sigma_));
    return true;
  }
  /// Sets the stationary pose: tilt, biases and zero velocity are determined, in the world frame that
  /// InertialInitializer gives to the window. `known` is the state of the body at the origin.
  void apply_stationary(State known, double accel_bias_sigma, auto& window, auto& navigation) {
    State x = window.latest();
    x.bias_gyro = known.bias_gyro;
    x.bias_accel = known.bias_accel;
    window.set_latest(x);
    known.T_world_body = T_world_initial_ * known.T_world_body;
    apply(known, accel_bias_sigma / gravity_, position_sigma_, navigation);
    was_stationary_ = true;
    // Departure is detected only once there is some speed.
    dead_reckoning_.begin(known, navigation.covariance(), S(velocity_sigma_));
  }

 private:
  double traveled(const SE3<S>& T) const { return double(norm(T.p() - T_world_initial_.p())); }
  /// Sets a state with the sigmas of its tilt [rad] and position [m].
  static void apply(const State& x, double tilt_sigma, double position_sigma, auto& navigation) {
    navigation.set_state(x);
    Covariance P = zeros<Covariance>();
    for (int k = 0; k < 3; ++k) {
      P(k, k) = S(tilt_sigma * tilt_sigma);
      P(3 + k, 3 + k) = S(position_sigma * position_sigma);
    }
    navigation.set_window_covariance(P);
  }

  DeadReckoningOptions options_;
  double gravity_;         ///< [m/s^2]
  double velocity_sigma_;  ///< [m/s]
  double position_sigma_;  ///< of a stationary body [m]
  DeadReckoning<S> dead_reckoning_;
  SE3<S> T_world_initial_;       ///< pose at the start of this initialization, upright
  State initial_state_;          ///< latest state when initialization was completed
  bool was_stationary_ = false;  ///< dead reckoning started from a stationary pose
};

}  // namespace plumbline
