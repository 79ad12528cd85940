#pragma once
/// Rigid transforms SE(3): T_a_b maps b-coordinates into a, x_a = R x_b + p.                docs/math/lie.md
///
///   exp(xi) = (Exp(phi), Jl(phi) rho),  xi = [phi; rho]                                                      (4)
///   Ad_T    = [R 0; [p]x R  R]                                                                               (5)
///   Jl6(xi) = [Jl 0; Q Jl]                                                                                   (6)
///
/// The estimator's retraction is NOT exp but `plus` of lie/plus.hpp: rotation and translation apart.

#include <cmath>
#include <concepts>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
class SE3 {
 public:
  using Scalar = S;
  static constexpr int dof = 6;
  using Tangent = Vec<S, 6>;
  using Matrix6 = Mat<S, 6, 6>;

  SE3() : p_(zeros<S, 3>()) {}
  SE3(const SO3<S>& rotation, const Vec<S, 3>& p) : rotation_(rotation), p_(p) {}

  static SE3 exp(const Tangent& xi) {
    const Vec<S, 3> phi = segment<3>(xi, 0);
    return SE3(SO3<S>::exp(phi), SO3<S>::left_jacobian(phi) * segment<3>(xi, 3));  // (4)
  }
  Tangent log() const {
    const Vec<S, 3> phi = rotation_.log();
    Tangent xi;
    xi << phi, SO3<S>::left_jacobian_inverse(phi) * p_;
    return xi;
  }

  SE3 inverse() const {
    const SO3<S> R_inverse = rotation_.inverse();
    return SE3(R_inverse, -(R_inverse * p_));
  }
  SE3 operator*(const SE3& other) const { return SE3(rotation_ * other.rotation_, rotation_ * other.p_ + p_); }
  Vec<S, 3> operator*(const Vec<S, 3>& x) const { return rotation_ * x + p_; }

  Mat<S, 3, 3> R() const { return rotation_.matrix(); }
  const SO3<S>& rotation() const { return rotation_; }
  const Vec<S, 3>& p() const { return p_; }
  bool is_finite() const { return all_finite(p_) && rotation_.is_finite(); }

  template <std::floating_point Other>
  SE3<Other> cast() const {
    return SE3<Other>(rotation_.template cast<Other>(), cast_to<Other>(p_));
  }

  Matrix6 adjoint() const {
    const Mat<S, 3, 3> R = rotation_.matrix();
    Matrix6 out = zeros<Matrix6>();  // (5)
    set_block(out, 0, 0, R);
    set_block(out, 3, 0, product(hat(p_), R));
    set_block(out, 3, 3, R);
    return out;
  }

  static Matrix6 left_jacobian(const Tangent& xi) {
    const Mat<S, 3, 3> J = SO3<S>::left_jacobian(segment<3>(xi, 0));
    Matrix6 out;
    out << J, zeros<S, 3, 3>(), coupling(xi), J;  // (6)
    return out;
  }
  static Matrix6 left_jacobian_inverse(const Tangent& xi) {
    const Mat<S, 3, 3> J = SO3<S>::left_jacobian_inverse(segment<3>(xi, 0));
    Matrix6 out;
    out << J, zeros<S, 3, 3>(), -J * coupling(xi) * J, J;
    return out;
  }
  static Matrix6 right_jacobian(const Tangent& xi) { return left_jacobian(-xi); }
  static Matrix6 right_jacobian_inverse(const Tangent& xi) { return left_jacobian_inverse(-xi); }

 private:
  /// Q of (6).
  static Mat<S, 3, 3> coupling(const Tangent& xi) {
    const Vec<S, 3> phi = segment<3>(xi, 0);
    const Mat<S, 3, 3> P = hat(phi), Rh = hat(segment<3>(xi, 3));
    const S t = squared_norm(phi);
    S c1, c2, c3;
    if (t < RotationCoefficients<S>::series_below) {
      c1 = S(1) / 6 + t * (S(-1) / 120 + t * (S(1) / 5040 + t * (S(-1) / 362880)));
      c2 = S(1) / 24 + t * (S(-1) / 720 + t * (S(1) / 40320 + t * (S(-1) / 3628800)));
      c3 = S(1) / 120 + t * (S(-1) / 2520 + t * (S(1) / 120960 + t * (S(-1) / 9979200)));
    } else {
      const S th = std::sqrt(t), s = elementary::sin(th), c = elementary::cos(th);
      c1 = (th - s) / (t * th);
      c2 = (t + 2 * c - 2) / (2 * t * t);
      c3 = (2 * th - 3 * s + th * c) / (2 * t * t * th);
    }
    const Mat<S, 3, 3> PRh = P * Rh, RhP = Rh * P, PRhP = PRh * P;
    return S(0.5) * Rh + c1 * (PRh + RhP + PRhP) + c2 * (P * PRh + RhP * P - 3 * PRhP) + c3 * (PRhP * P + P * PRhP);
  }

  SO3<S> rotation_;
  Vec<S, 3> p_;
};

static_assert(LieGroup<SE3<float>> && LieGroup<SE3<double>>);

}  // namespace plumbline
