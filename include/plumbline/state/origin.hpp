#pragma once
/// Where an estimate began, or began anew: what is not known of that place is not known of any pose after it. Nor is
/// what the calibration of lens, depth and readings is wrong by: no residual shows it, and it grows with the way.
///
///   P(T) = P_window + Ad P_origin Ad^T + diag((k a + a_d)^2 I, (k s + s_d)^2 I),   Ad = Ad(T^-1 T_origin)     (1)
/// a, s: angle turned and distance travelled since the origin; a_d, s_d: those that are in dispute, because one sensor
/// excludes what another one says: one of them is wrong by as much, and time after time in the same direction. Where
/// gravity shows, the angle that adds up is that about the vertical: the tilt has a_d alone.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Covariance P of a body at T [rad, m], right increments, as one of the same body at T_elsewhere: the Ad of (1).
template <class S>
Mat<S, 6, 6> carried(const Mat<S, 6, 6>& P, const SE3<S>& T, const SE3<S>& T_elsewhere) {
  const Mat<S, 6, 6> Ad = (T_elsewhere.inverse() * T).adjoint();
  return Ad * P * Ad.transpose();
}

/// What remains of P, of a body with that rotation, where gravity shows: of the rotation the heading.
template <class S>
Mat<S, 6, 6> place_and_heading(const Mat<S, 6, 6>& P, const SO3<S>& R_world_body) {
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

template <class S>
class Origin {
 public:
  using Covariance = Mat<S, 6, 6>;

  /// `calibration_error`: k of (1).
  explicit Origin(S calibration_error = S(0), bool gravity_shows = false)
      : calibration_error_(calibration_error), gravity_shows_(gravity_shows) {}

  /// It is at T, of which that much is known.
  void set(const SE3<S>& T, const Covariance& P) {
    T_ = latest_ = T;
    P_ = P;
    angle_ = distance_ = disputed_angle_ = disputed_distance_ = S(0);
  }
  /// The body has come to T.
  void travel_to(const SE3<S>& T) {
    const SE3<S> way = latest_.inverse() * T;
    angle_ += norm(way.rotation().log());
    distance_ += norm(way.p());
    latest_ = T;
  }
  /// Whether the body was moved by that much, [dphi, dp], depends on whom one believes.
  void dispute(const Vec<S, 6>& d) {
    disputed_angle_ += norm(segment<3>(d, 0));
    disputed_distance_ += norm(segment<3>(d, 3));
  }
  /// What was travelled on the way to T was no way.
  void begin_way(const SE3<S>& T) { set(T, carried(P_, T_, T)); }
  /// What is measured from T on has that place with a sigma [m], and that heading about the vertical [rad].
  void doubt(const SE3<S>& T, S place_sigma, S heading_sigma) {
    refer_to(T);
    const Vec<S, 3> up = T.rotation().inverse() * Vec<S, 3>(0, 0, 1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) P_(i, k) += heading_sigma * heading_sigma * up[i] * up[k];
      P_(3 + i, 3 + i) += place_sigma * place_sigma;
    }
  }
  /// The body that is at T now may be turned by that much [rad], about any axis.
  void doubt_rotation(const SE3<S>& T, S sigma) {
    refer_to(T);
    for (int i = 0; i < 3; ++i) P_(i, i) += sigma * sigma;
  }
  /// The part of a pose's covariance that is the origin's and the way's.
  Covariance at(const SE3<S>& T) const {
    Covariance P = carried(P_, T_, T);
    const S turned = squared(calibration_error_ * angle_ + disputed_angle_);
    const S tilted = gravity_shows_ ? squared(disputed_angle_) : turned;
    const S travelled = squared(calibration_error_ * distance_ + disputed_distance_);
    const Vec<S, 3> up = T.rotation().inverse() * Vec<S, 3>(0, 0, 1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) P(i, k) += (turned - tilted) * up[i] * up[k];
      P(i, i) += tilted;
      P(3 + i, 3 + i) += travelled;
    }
    return P;
  }

 private:
  void refer_to(const SE3<S>& T) {
    P_ = carried(P_, T_, T);
    T_ = T;
  }
  static S squared(S x) { return x * x; }

  S calibration_error_;
  bool gravity_shows_;
  SE3<S> T_, latest_;
  Covariance P_ = zeros<Covariance>();
  S angle_ = S(0), distance_ = S(0), disputed_angle_ = S(0), disputed_distance_ = S(0);
};

}  // namespace plumbline
