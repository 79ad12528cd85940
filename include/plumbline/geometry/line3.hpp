#pragma once
/// Infinite lines in space.                                                                 docs/math/line.md
///
///   Pluecker      n = p x q (moment), v = q - p (direction), n . v = 0, both up to one common scale           (1)
///   distance      d = |n| / |v|,  nearest point of the origin p0 = v x n / |v|^2
///   transform     n_a = R n_b + p x (R v_b),  v_a = R v_b,  d(n_a; v_a)/d(n_b; v_b) = [R, [p]x R; 0, R]       (2)
///   orthonormal   n = w1 u1,  v = w2 u2,  U = [u1 u2 u3] in SO(3),  w1^2 + w2^2 = 1,  w2 > 0                  (3)
///   plus(L, [dth; dw]) = (U Exp(dth), (w1 cos dw - w2 sin dw, w2 cos dw + w1 sin dw))                         (4)
///   d(n; v)/d[dth; dw] = [0, -w1 u3, w1 u2, -w2 u1;  w2 u3, 0, -w2 u1, w1 u2]                       6x4       (5)
///   minus(L, L0) = [Log(U0^T U); atan2(w2, w1) - atan2(w20, w10)],  d minus/dL = blkdiag(Jr^-1(Log), 1)       (6)
/// (5) loses rank at d = 0: a line belongs to the frame of a camera that sees it, whose origin it keeps clear of.
/// During an optimization w1 may change its sign; that is regular.

#include <cmath>
#include <concepts>
#include <limits>

#include <Eigen/Geometry>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

/// (1), homogeneous: any common scale.
template <std::floating_point S>
struct Plucker {
  Vec<S, 3> n;  ///< normal of the plane through the line and the origin; projects to the image line n . m = 0
  Vec<S, 3> v;  ///< direction

  /// Points to the nearest point of the origin; its plane q . x = 1 holds the line and faces the origin.       (7)
  Vec<S, 3> facing_plane() const { return v.cross(n) / squared_norm(n); }

  /// The point of the line beside the ray of `bearing` (any length): the ray's nearest one in the image. Behind the
  /// origin when the ray does not meet the line in front, not finite when it is parallel.                      (8)
  Vec<S, 3> point_along(const Vec<S, 3>& bearing) const {
    return (bearing * squared_norm(n) - n * dot(n, bearing)) / dot(bearing, v.cross(n));
  }
};

/// (2)
template <class S>
Plucker<S> operator*(const SE3<S>& T_a_b, const Plucker<S>& line_b) {
  const Vec<S, 3> v = T_a_b.rotation() * line_b.v;
  return {T_a_b.rotation() * line_b.n + T_a_b.p().cross(v), v};
}

/// The 6x6 matrix of (2), T_a_b = (R, p).
template <class S>
Mat<S, 6, 6> plucker_transform(const SE3<S>& T_a_b) {
  const Mat<S, 3, 3> R = T_a_b.R();
  Mat<S, 6, 6> out = zeros<S, 6, 6>();
  set_block(out, 0, 0, R);
  set_block(out, 0, 3, product(hat(T_a_b.p()), R));
  set_block(out, 3, 3, R);
  return out;
}

/// (3)
template <std::floating_point S>
class Line3 {
 public:
  using Scalar = S;
  static constexpr int dof = 4;

  Line3() : w1_(std::sqrt(S(0.5))), w2_(std::sqrt(S(0.5))) {}
  /// Of any scale; the part of n along v is left out. Not finite when v is zero.
  explicit Line3(const Plucker<S>& line) {
    const Vec<S, 3> u2 = normalized(line.v), n = line.n - u2 * dot(u2, line.n);
    const S n_norm = norm(n), v_norm = norm(line.v);
    const bool has_moment = n_norm > std::numeric_limits<S>::epsilon() * v_norm;  // else any u1 will do
    const Vec<S, 3> u1 = has_moment ? Vec<S, 3>(n / n_norm) : unit_orthogonal(u2);
    Mat<S, 3, 3> U;
    set_block(U, 0, 0, u1);
    set_block(U, 0, 1, u2);
    set_block(U, 0, 2, u1.cross(u2));
    U_ = SO3<S>::from_matrix(U);
    const S scale = S(1) / elementary::hypot(n_norm, v_norm);
    w1_ = n_norm * scale;
    w2_ = v_norm * scale;
  }
  /// From p to q; not finite when they coincide.
  static Line3 through(const Vec<S, 3>& p, const Vec<S, 3>& q) {
    const Vec<S, 3> v = q - p, middle = (p + q) / 2;
    return Line3(Plucker<S>{middle.cross(v), v});
  }

  Plucker<S> plucker() const {
    const Mat<S, 3, 3> U = U_.matrix();
    return {w1_ * column(U, 0), w2_ * column(U, 1)};
  }
  /// (5), rows n then v.
  Mat<S, 6, 4> plucker_jacobian() const {
    const Mat<S, 3, 3> U = U_.matrix();
    Mat<S, 6, 4> J;
    for (int i = 0; i < 3; ++i) {
      const S u1 = U(i, 0), u2 = U(i, 1), u3 = U(i, 2);
      J(i, 0) = S(0), J(i, 1) = -w1_ * u3, J(i, 2) = w1_ * u2, J(i, 3) = -w2_ * u1;
      J(3 + i, 0) = w2_ * u3, J(3 + i, 1) = S(0), J(3 + i, 2) = -w2_ * u1, J(3 + i, 3) = w1_ * u2;
    }
    return J;
  }

  Vec<S, 3> direction() const { return column(U_.matrix(), 1); }                     ///< unit
  S distance() const { return std::abs(w1_ / w2_); }                                 ///< to the origin [m]
  Vec<S, 3> closest_point() const { return (-w1_ / w2_) * column(U_.matrix(), 2); }  ///< to the origin [m]
  bool is_finite() const { return U_.is_finite() && std::isfinite(w1_) && std::isfinite(w2_); }

  const SO3<S>& U() const { return U_; }
  S w1() const { return w1_; }
  S w2() const { return w2_; }

  /// (4)
  Line3 plus(const Vec<S, 4>& d) const {
    const S c = elementary::cos(d[3]), s = elementary::sin(d[3]), w1 = w1_ * c - w2_ * s, w2 = w2_ * c + w1_ * s;
    const S scale = (w2 < S(0) ? S(-1) : S(1)) / elementary::hypot(w1, w2);  // both negated are the same line
    return {plumbline::plus(U_, segment<3>(d, 0)), scale * w1, scale * w2};
  }

  template <std::floating_point Other>
  Line3<Other> cast() const {
    const Plucker<S> line = plucker();
    return Line3<Other>({cast_to<Other>(line.n), cast_to<Other>(line.v)});
  }

 private:
  Line3(const SO3<S>& U, S w1, S w2) : U_(U), w1_(w1), w2_(w2) {}

  SO3<S> U_;
  S w1_, w2_;
};

template <class S>
Line3<S> operator*(const SE3<S>& T_a_b, const Line3<S>& line_b) {
  return Line3<S>(T_a_b * line_b.plucker());
}

template <class S>
Line3<S> plus(const Line3<S>& line, const Vec<S, 4>& d) {
  return line.plus(d);
}

/// (6)
template <class S>
Vec<S, 4> minus(const Line3<S>& line1, const Line3<S>& line0) {
  Vec<S, 4> d;
  set_segment(d, 0, minus(line1.U(), line0.U()));
  d[3] = elementary::atan2(line1.w2(), line1.w1()) - elementary::atan2(line0.w2(), line0.w1());
  return d;
}

/// d minus(line, line0) / d line, 4x4.
template <class S>
Mat<S, 4, 4> minus_jacobian(const Line3<S>& line, const Line3<S>& line0) {
  Mat<S, 4, 4> J = identity<S, 4>();
  set_block(J, 0, 0, minus_jacobian(line.U(), line0.U()));
  return J;
}

}  // namespace plumbline
