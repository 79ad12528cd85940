#pragma once
/// Similarities Sim(3): S_a_b = (s, R, t) maps b-coordinates into a, x_a = s R x_b + t.      docs/math/lie.md
///
///   S1 S2 = (s1 s2, R1 R2, s1 R1 t2 + t1),  S^-1 = (1/s, R^T, -R^T t/s)                                      (8)
///   exp(xi) = (e^sig, Exp(phi), W rho),  xi = [phi; rho; sig],  W = integral over u in [0, 1] of exp(u X),
///       X = sig I + [phi]x                                                                                    (9)
///   W(2X) = (exp(X) + I) W(X) / 2,  exp(X) = I + X W(X),  W(X) = sum over n of X^n / (n + 1)!                (10)
///   Ad = [R 0 0; [t]x R  s R  -t; 0 0 1]                                                                     (11)
///
/// The estimator's retraction is NOT exp but `plus` of lie/plus.hpp.

#include <cmath>
#include <concepts>

#include <Eigen/LU>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
class Sim3 {
 public:
  using Scalar = S;
  static constexpr int dof = 7;
  using Tangent = Vec<S, 7>;

  Sim3() : scale_(1), t_(zeros<S, 3>()) {}
  /// scale > 0
  Sim3(S scale, const SO3<S>& rotation, const Vec<S, 3>& t) : scale_(scale), rotation_(rotation), t_(t) {}
  explicit Sim3(const SE3<S>& T) : Sim3(S(1), T.rotation(), T.p()) {}

  static Sim3 exp(const Tangent& xi) {
    const Vec<S, 3> phi = segment<3>(xi, 0);
    return Sim3(elementary::exp(xi[6]), SO3<S>::exp(phi), translation_factor(phi, xi[6]) * segment<3>(xi, 3));  // (9)
  }
  Tangent log() const {
    const Vec<S, 3> phi = rotation_.log();
    const S sigma = elementary::log(scale_);
    Tangent xi;
    xi << phi, translation_factor(phi, sigma).inverse() * t_, sigma;
    return xi;
  }

  Sim3 inverse() const {  // (8)
    const SO3<S> R_inverse = rotation_.inverse();
    return Sim3(1 / scale_, R_inverse, -(R_inverse * t_) / scale_);
  }
  Sim3 operator*(const Sim3& other) const {
    return Sim3(scale_ * other.scale_, rotation_ * other.rotation_, *this * other.t_);
  }
  Vec<S, 3> operator*(const Vec<S, 3>& x) const { return scale_ * (rotation_ * x) + t_; }

  S scale() const { return scale_; }
  const SO3<S>& rotation() const { return rotation_; }
  Mat<S, 3, 3> R() const { return rotation_.matrix(); }
  const Vec<S, 3>& t() const { return t_; }
  bool is_finite() const {
    return std::isfinite(scale_) && all_finite(t_) && all_finite(rotation_.quaternion().coeffs());
  }

  template <std::floating_point Other>
  Sim3<Other> cast() const {
    return Sim3<Other>(static_cast<Other>(scale_), rotation_.template cast<Other>(), cast_to<Other>(t_));
  }

  Mat<S, 7, 7> adjoint() const {
    const Mat<S, 3, 3> R = rotation_.matrix();
    Mat<S, 7, 7> out = identity<S, 7>();
    set_block(out, 0, 0, R);
    out.template block<3, 7>(3, 0) << hat(t_) * R, scale_ * R, -t_;  // (11)
    return out;
  }

 private:
  /// W of (9): Taylor series after halving X to norm 1/2, then doubled back by (10). No angle or scale is special.
  static Mat<S, 3, 3> translation_factor(const Vec<S, 3>& phi, S sigma) {
    const Mat<S, 3, 3> I = identity<S, 3>();
    S norm = std::sqrt(squared_norm(phi) + sigma * sigma), shrink = 1;
    int halvings = 0;
    for (; norm > S(0.5) && halvings < 10; ++halvings, norm /= 2) shrink /= 2;
    Mat<S, 3, 3> X = shrink * (sigma * I + hat(phi)), W = I;
    for (int n = 13; n > 0; --n) W = (I + X * W / S(n + 1)).eval();  // Horner: |X|^14 / 15! < 1e-16
    for (int i = 0; i < halvings; ++i, X *= 2) W = ((I + S(0.5) * X * W) * W).eval();
    return W;
  }

  S scale_;
  SO3<S> rotation_;
  Vec<S, 3> t_;  ///< [m of a]
};

static_assert(LieGroup<Sim3<float>> && LieGroup<Sim3<double>>);

}  // namespace plumbline
