#pragma once
/// The navigation state of the latest frame: pose, velocity and biases in the world frame, and the covariance of the
/// pose with the uncertainty of the world frame. Outages propagate it, a reset starts from it, the publisher copies it.
///                                                                               docs/math/inertial_window.md (1i)

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/frame_state.hpp"
#include "plumbline/state/layout.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

template <class S, class LayoutT>
class Navigation {
 public:
  using State = FrameValue<S, LayoutT>;
  using Covariance = Mat<S, state::Pose::dim, state::Pose::dim>;  ///< of [dphi, dp], right increments [rad, m]

  explicit Navigation(const WorldFrameUncertainty<S>& world) : world_(world) {}

  /// Time of the latest frame [ns].
  TimeNs t_ns() const { return t_ns_; }
  const State& state() const { return x_; }
  const SE3<S>& T_world_body() const { return x_.T_world_body; }
  const Covariance& covariance() const { return P_; }
  WorldFrameUncertainty<S>& world() { return world_; }

  void set_time(TimeNs t_ns) { t_ns_ = t_ns; }
  /// The body has moved along its path to the pose T.
  void move_to(const SE3<S>& T) {
    x_.T_world_body = T;
    world_.move_to(T);
  }
  /// Corrects the pose, without a path.
  void set_pose(const SE3<S>& T) { x_.T_world_body = T; }
  /// Sets velocity and biases to those of x.
  void set_motion(const State& x) {
    if constexpr (LayoutT::template has<state::Velocity>) {
      x_.v_world_body = x.v_world_body;
      x_.bias_gyro = x.bias_gyro;
      x_.bias_accel = x.bias_accel;
    }
  }
  /// Sets pose, velocity and biases, without a path.
  void set_state(const State& x) {
    set_pose(x.T_world_body);
    set_motion(x);
  }
  void set_covariance(const Covariance& P) { P_ = P; }
  /// Sets the covariance of a pose that the window knows with the covariance P: that of the world frame is added.
  void set_window_covariance(const Covariance& P) { P_ = P + world_.at(x_.T_world_body); }
  /// Adds independent variances, rotation_sigma^2 [rad^2] and position_sigma^2 [m^2], on each axis.
  void add_variance(S rotation_variance, S position_variance) {
    for (int k = 0; k < 3; ++k) {
      P_(k, k) += rotation_variance;
      P_(3 + k, 3 + k) += position_variance;
    }
  }

 private:
  TimeNs t_ns_ = 0;
  State x_;
  Covariance P_ = identity<S, state::Pose::dim>();
  WorldFrameUncertainty<S> world_;
};

}  // namespace plumbline
