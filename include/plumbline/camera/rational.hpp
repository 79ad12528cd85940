#pragma once
/// Rational lens distortion of 8 coefficients (OpenCV's rational model, ROS rational_polynomial), a policy of Pinhole.
///                                                                                         docs/math/camera.md
///
///   q = |m|^2,  n = 1 + k1 q + k2 q^2 + k3 q^3,  e = 1 + k4 q + k5 q^2 + k6 q^3,  d = n/e,
///       d' = (n' e - n e')/e^2                                                                               (15)
///   m', J: those of radial-tangential distortion (3), (4) with this d and d'
///   valid for |m| < r_max: the radius grows up to there,  n e + 2 q (n' e - n e') > 0,  and e > 0             (16)

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "plumbline/camera/monotone_limit.hpp"
#include "plumbline/camera/newton_inverse.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// Written `Pinhole<float, Rational>{fx, fy, cx, cy, {k1, k2, p1, p2, k3, k4, k5, k6}}`, in OpenCV's order.
template <std::floating_point S>
class Rational {
 public:
  using Distorted = typename NoDistortion<S>::Distorted;
  static constexpr S r_limit = S(20);  ///< tan of the widest angle to the axis, 87 deg

  Rational() : Rational(0, 0, 0, 0, 0, 0, 0, 0) {}
  Rational(S k1, S k2, S p1, S p2, S k3, S k4, S k5, S k6)
      : n_{k1, k2, k3}, e_{k4, k5, k6}, p1_(p1), p2_(p2), q_max_(largest_q()) {}

  S k1() const { return n_[0]; }
  S k2() const { return n_[1]; }
  S p1() const { return p1_; }
  S p2() const { return p2_; }
  S k3() const { return n_[2]; }
  S k4() const { return e_[0]; }
  S k5() const { return e_[1]; }
  S k6() const { return e_[2]; }
  S r_max() const { return std::sqrt(q_max_); }

  /// m' and d m' / d m.
  Distorted distort(const Vec<S, 2>& m) const {
    const S x = m.x(), y = m.y(), q = squared_norm(m);
    const Value n = value_of(n_, q), e = value_of(e_, q);
    const S d = n.f / e.f, dd = (n.df - d * e.df) / e.f;  // (15)
    const S o = 2 * (x * y * dd + p1_ * x + p2_ * y);
    Distorted out;
    out.valid = q < q_max_;  // false for NaN too
    out.m << x * d + 2 * p1_ * x * y + p2_ * (q + 2 * x * x), y * d + p1_ * (q + 2 * y * y) + 2 * p2_ * x * y;
    out.J << d + 2 * x * x * dd + 2 * p1_ * y + 6 * p2_ * x, o, o, d + 2 * y * y * dd + 6 * p1_ * y + 2 * p2_ * x;
    return out;
  }

  /// m and d m / d m'; invalid where there is no point of the domain.
  Distorted undistort(const Vec<S, 2>& m_distorted) const { return newton_inverse<S>(*this, m_distorted); }

 private:
  using Coefficients = std::array<S, 3>;
  struct Value {
    S f, df;
  };
  static Value value_of(const Coefficients& c, S q) {
    return {1 + q * (c[0] + q * (c[1] + q * c[2])), c[0] + q * (2 * c[1] + q * 3 * c[2])};
  }

  /// (16): the product of q^a in n and q^b in e has the factor 1 + 2 (a - b).
  S largest_q() const {
    std::array<S, 6> growth{};
    for (int a = 0; a <= 3; ++a) {
      for (int b = 0; b <= 3; ++b) {
        if (a + b == 0) continue;
        const S n = a == 0 ? S(1) : n_[std::size_t(a - 1)], e = b == 0 ? S(1) : e_[std::size_t(b - 1)];
        growth[std::size_t(a + b - 1)] += n * e * S(1 + 2 * (a - b));
      }
    }
    return std::min(monotone_limit<S, 6>(growth, r_limit * r_limit), monotone_limit<S, 3>(e_, r_limit * r_limit));
  }

  Coefficients n_, e_;  ///< k1 k2 k3 of the numerator, k4 k5 k6 of the denominator
  S p1_, p2_;
  S q_max_;  ///< r_max^2
};

static_assert(CameraModel<Pinhole<float, Rational>> && CameraModel<Pinhole<double, Rational>>);

}  // namespace plumbline
