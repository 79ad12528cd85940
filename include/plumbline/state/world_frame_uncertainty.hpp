#pragma once
/// Uncertainty of the world frame: covariance of the pose at which the world began, and of the path since then.
///
/// The covariance of a window is relative to its prior; it contains neither the uncertainty of the pose at which the
/// estimate began or was reset, nor the error of the calibration (lens, depth, IMU scale), which grows with the path
/// and which no residual shows.                                                       docs/math/inertial_window.md (1i)
///   P(T) = P_window + Ad P_origin Ad^T + diag((k a + a_d)^2 I, (k s + s_d)^2 I),   Ad = Ad(T^-1 T_origin)     (1)
/// a, s: angle turned [rad] and path length [m] since the origin; k: calibration error; a_d, s_d: inflation for motion
/// on which two sensors contradict each other, summed linearly because such errors repeat with the same sign. With
/// gravity the tilt is observable: k a is then about the vertical alone, the tilt has a_d.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Transports the covariance P [rad, m] of a pose T (right increments) to the pose T_elsewhere of the same rigid body,
/// Ad P Ad^T of (1).
template <class S>
Mat<S, 6, 6> transported(const Mat<S, 6, 6>& P, const SE3<S>& T, const SE3<S>& T_elsewhere) {
  const Mat<S, 6, 6> Ad = (T_elsewhere.inverse() * T).adjoint();
  return Ad * P * Ad.transpose();
}

/// Covariance P of a pose without the uncertainty of the tilt: position and, of the rotation, the heading.
template <class S>
Mat<S, 6, 6> position_and_heading(const Mat<S, 6, 6>& P, const SO3<S>& R_world_body) {
  const Vec<S, 3> up = R_world_body.inverse() * Vec<S, 3>(0, 0, 1);
  S heading = S(0);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) heading += up[i] * P(i, k) * up[k];
  }
  Mat<S, 6, 6> out = P;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      out(i, k) = heading * up[i] * up[k];
      out(i, 3 + k) = out(3 + k, i) = S(0);
    }
  }
  return out;
}

/// P(T) - P_window of (1).
template <class S>
class WorldFrameUncertainty {
 public:
  using Covariance = Mat<S, 6, 6>;

  /// `calibration_error`: k of (1), relative. `has_gravity`: the tilt is observable.
  explicit WorldFrameUncertainty(S calibration_error = S(0), bool has_gravity = false)
      : calibration_error_(calibration_error), has_gravity_(has_gravity) {}

  /// The origin is T with the covariance P; the path begins there.
  void set(const SE3<S>& T, const Covariance& P) {
    T_ = latest_ = T;
    P_ = P;
    angle_ = distance_ = inflated_angle_ = inflated_distance_ = S(0);
  }
  /// Adds the motion from the last pose to T to angle and path length.
  void move_to(const SE3<S>& T) {
    const SE3<S> step = latest_.inverse() * T;
    angle_ += norm(step.rotation().log());
    distance_ += norm(step.p());
    latest_ = T;
  }
  /// Adds the norms of d = [dphi, dp], a motion on which two sensors contradict each other, to the inflation.
  void inflate(const Vec<S, 6>& d) {
    inflated_angle_ += norm(segment<3>(d, 0));
    inflated_distance_ += norm(segment<3>(d, 3));
  }
  /// Moves the origin to T and discards the path up to there.
  void restart_path(const SE3<S>& T) { set(T, transported(P_, T_, T)); }
  /// Adds uncertainty of position [m] and heading [rad] at T, common to all later poses.
  void add_uncertainty(const SE3<S>& T, S position_sigma, S heading_sigma) {
    refer_to(T);
    const Vec<S, 3> up = T.rotation().inverse() * Vec<S, 3>(0, 0, 1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) P_(i, k) += heading_sigma * heading_sigma * up[i] * up[k];
      P_(3 + i, 3 + i) += position_sigma * position_sigma;
    }
  }
  /// Adds uncertainty of the rotation about all axes [rad] at T.
  void add_rotation_uncertainty(const SE3<S>& T, S sigma) {
    refer_to(T);
    for (int i = 0; i < 3; ++i) P_(i, i) += sigma * sigma;
  }
  /// Covariance of a pose T due to origin and path, to be added to that of the window.
  Covariance at(const SE3<S>& T) const {
    Covariance P = transported(P_, T_, T);
    const S turned = squared(calibration_error_ * angle_ + inflated_angle_);
    const S tilted = has_gravity_ ? squared(inflated_angle_) : turned;
    const S traveled = squared(calibration_error_ * distance_ + inflated_distance_);
    const Vec<S, 3> up = T.rotation().inverse() * Vec<S, 3>(0, 0, 1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) P(i, k) += (turned - tilted) * up[i] * up[k];
      P(i, i) += tilted;
      P(3 + i, 3 + i) += traveled;
    }
    return P;
  }

 private:
  /// Transports the origin to T.
  void refer_to(const SE3<S>& T) {
    P_ = transported(P_, T_, T);
    T_ = T;
  }
  static S squared(S x) { return x * x; }

  S calibration_error_;
  bool has_gravity_;
  SE3<S> T_, latest_;
  Covariance P_ = zeros<Covariance>();
  S angle_ = S(0), distance_ = S(0), inflated_angle_ = S(0), inflated_distance_ = S(0);
};

}  // namespace plumbline
