#pragma once
/// Rotations SO(3), stored as a unit quaternion with w >= 0.                                docs/math/lie.md
///
///   Exp(phi)   = I + A P + B P^2,  P = [phi]x                                                                (1)
///   Jr(phi)    = I - B P + C P^2,  Jl(phi) = Jr(-phi)                                                        (2)
///   Jr^-1(phi) = I + P/2 + D P^2,  Jl^-1(phi) = Jr^-1(-phi)                                                  (3)
///   Exp(phi + d) = Exp(phi) Exp(Jr(phi) d) + O(d^2),  Log(Exp(phi) Exp(d)) = phi + Jr^-1(phi) d + O(d^2)

#include <cmath>
#include <concepts>
#include <type_traits>

#include <Eigen/Geometry>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/lie_group.hpp"

namespace plumbline {

/// The four coefficients of (1)-(3) as functions of t = |phi|^2, by series where the closed forms cancel.
template <std::floating_point S>
struct RotationCoefficients {
  S A, B, C, D;  ///< sin th/th, (1-cos th)/th^2, (th-sin th)/th^3, 1/th^2 - cot(th/2)/(2 th)

  static constexpr S series_below = std::is_same_v<S, float> ? S(1) : S(1e-2);  ///< on t

  static RotationCoefficients at(S t) {
    if (t < series_below) {
      return {S(1) + t * (S(-1) / 6 + t * (S(1) / 120 + t * (S(-1) / 5040 + t * (S(1) / 362880)))),
              S(0.5) + t * (S(-1) / 24 + t * (S(1) / 720 + t * (S(-1) / 40320 + t * (S(1) / 3628800)))),
              S(1) / 6 + t * (S(-1) / 120 + t * (S(1) / 5040 + t * (S(-1) / 362880 + t * (S(1) / 39916800)))),
              S(1) / 12 + t * (S(1) / 720 + t * (S(1) / 30240 + t * (S(1) / 1209600 + t * (S(1) / 47900160))))};
    }
    const S th = std::sqrt(t), s = elementary::sin(th), half = elementary::sin(th / 2);
    return {s / th, 2 * half * half / t, (th - s) / (t * th), 1 / t - elementary::cos(th / 2) / (2 * th * half)};
  }
};

template <std::floating_point S>
class SO3 {
 public:
  using Scalar = S;
  static constexpr int dof = 3;
  using Tangent = Vec<S, 3>;
  using Matrix = Mat<S, 3, 3>;

  SO3() : q_(S(1), S(0), S(0), S(0)) {}
  explicit SO3(const Eigen::Quaternion<S>& q) : SO3(Eigen::Quaternion<S>(normalized(q.coeffs())), NearlyUnit{}) {}
  /// The rotation of an (approximately) orthonormal matrix, by largest-pivot extraction.
  static SO3 from_matrix(const Matrix& R) { return SO3(Eigen::Quaternion<S>(R)); }

  static SO3 exp(const Tangent& phi) {
    const S t = squared_norm(phi), th_half = std::sqrt(t) / 2;
    const S sinc_half = RotationCoefficients<S>::at(t / 4).A / 2;  // sin(th/2)/th
    return SO3({elementary::cos(th_half), sinc_half * phi.x(), sinc_half * phi.y(), sinc_half * phi.z()}, NearlyUnit{});
  }

  /// Rotation vector in the ball of radius pi; the sign of the axis is arbitrary exactly at pi.
  Tangent log() const {
    const Vec<S, 3> v = vector_part();
    const S n = norm(v), w = q_.w();
    const S small = std::is_same_v<S, float> ? S(1e-2) : S(1e-5);
    if (n < small) return (2 / w) * (1 - n * n / (3 * w * w)) * v;
    return (2 * elementary::atan2(n, w) / n) * v;
  }

  SO3 inverse() const {
    SO3 out;
    out.q_ = q_.conjugate();
    return out;
  }
  SO3 operator*(const SO3& other) const { return SO3(q_ * other.q_, NearlyUnit{}); }
  Vec<S, 3> operator*(const Vec<S, 3>& x) const {
    const Vec<S, 3> v = vector_part(), half = v.cross(x), turned = half + half;
    return x + q_.w() * turned + v.cross(turned);
  }

  Matrix matrix() const { return q_.toRotationMatrix(); }
  Matrix adjoint() const { return matrix(); }
  const Eigen::Quaternion<S>& quaternion() const { return q_; }
  bool is_finite() const { return all_finite(q_.coeffs()); }

  template <std::floating_point Other>
  SO3<Other> cast() const {
    return SO3<Other>(Eigen::Quaternion<Other>(cast_to<Other>(q_.coeffs())));
  }

  static Matrix right_jacobian(const Tangent& phi) {
    const RotationCoefficients<S> c = RotationCoefficients<S>::at(squared_norm(phi));
    return quadratic(phi, -c.B, c.C);  // (2)
  }
  static Matrix left_jacobian(const Tangent& phi) { return right_jacobian(-phi); }

  static Matrix right_jacobian_inverse(const Tangent& phi) {
    const RotationCoefficients<S> c = RotationCoefficients<S>::at(squared_norm(phi));
    return quadratic(phi, S(0.5), c.D);  // (3)
  }
  static Matrix left_jacobian_inverse(const Tangent& phi) { return right_jacobian_inverse(-phi); }

 private:
  /// I + b P + c P^2,  P = [phi]x,  P^2 = phi phi^T - |phi|^2 I
  static Matrix quadratic(const Tangent& phi, S b, S c) {
    const Tangent b_phi = b * phi;
    const S rest = S(1) - c * squared_norm(phi);
    Matrix out = hat(b_phi);
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) out(i, j) += c * phi[i] * phi[j];
      out(j, j) += rest;
    }
    return out;
  }

  /// For |q|^2 = 1 + e with e a few roundings: one step of 1/sqrt(1 + e) = (3 - |q|^2)/2 + O(e^2), so products never
  /// drift.
  struct NearlyUnit {};
  SO3(const Eigen::Quaternion<S>& q, NearlyUnit) : q_(q) {
    const S scale = (3 - squared_norm(q.coeffs())) / 2;
    q_.coeffs() = (q.w() < S(0) ? -scale : scale) * q.coeffs();
  }
  Vec<S, 3> vector_part() const { return {q_.x(), q_.y(), q_.z()}; }

  Eigen::Quaternion<S> q_;
};

static_assert(LieGroup<SO3<float>> && LieGroup<SO3<double>>);
static_assert(!LieGroup<Eigen::Quaternion<float>>);

}  // namespace plumbline
