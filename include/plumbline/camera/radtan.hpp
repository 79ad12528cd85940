#pragma once
/// Radial-tangential lens distortion (Brown-Conrady, OpenCV's plumb bob), a policy of Pinhole.   docs/math/camera.md
///
///   q = |m|^2,  d = 1 + k1 q + k2 q^2 + k3 q^3,  d' = dd/dq                                                  (3)
///   m'_x = m_x d + 2 p1 m_x m_y + p2 (q + 2 m_x^2),  m'_y = m_y d + p1 (q + 2 m_y^2) + 2 p2 m_x m_y
///   J = [d + 2 m_x^2 d' + 2 p1 m_y + 6 p2 m_x, o; o, d + 2 m_y^2 d' + 6 p1 m_y + 2 p2 m_x],
///       o = 2 m_x m_y d' + 2 p1 m_x + 2 p2 m_y                                                                (4)
///   valid for |m| < r_max: the radius grows up to there,  d + 2 q d' > 0                                     (5)

#include <cmath>
#include <concepts>

#include "plumbline/camera/monotone_limit.hpp"
#include "plumbline/camera/newton_inverse.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// Written `Pinhole<float, RadTan>{fx, fy, cx, cy, {k1, k2, p1, p2, k3}}`.
template <std::floating_point S>
class RadTan {
 public:
  using Distorted = typename NoDistortion<S>::Distorted;
  static constexpr S r_limit = S(20);  ///< tan of the widest angle to the axis, 87 deg

  RadTan() : RadTan(0, 0, 0, 0) {}
  RadTan(S k1, S k2, S p1, S p2, S k3 = 0)
      : k1_(k1),
        k2_(k2),
        p1_(p1),
        p2_(p2),
        k3_(k3),
        q_max_(monotone_limit<S, 3>({3 * k1, 5 * k2, 7 * k3}, r_limit * r_limit)) {}  // (5)

  S k1() const { return k1_; }
  S k2() const { return k2_; }
  S p1() const { return p1_; }
  S p2() const { return p2_; }
  S k3() const { return k3_; }
  S r_max() const { return std::sqrt(q_max_); }

  /// m' and d m' / d m.
  Distorted distort(const Vec<S, 2>& m) const {
    const S x = m.x(), y = m.y(), q = squared_norm(m);
    const S d = 1 + q * (k1_ + q * (k2_ + q * k3_)), dd = k1_ + q * (2 * k2_ + q * 3 * k3_);  // (3)
    const S o = 2 * (x * y * dd + p1_ * x + p2_ * y);
    Distorted out;
    out.valid = q < q_max_;  // false for NaN too
    out.m << x * d + 2 * p1_ * x * y + p2_ * (q + 2 * x * x), y * d + p1_ * (q + 2 * y * y) + 2 * p2_ * x * y;
    out.J << d + 2 * x * x * dd + 2 * p1_ * y + 6 * p2_ * x, o, o,
        d + 2 * y * y * dd + 6 * p1_ * y + 2 * p2_ * x;  // (4)
    return out;
  }

  /// m and d m / d m'; invalid where there is no point of the domain.
  Distorted undistort(const Vec<S, 2>& m_distorted) const { return newton_inverse<S>(*this, m_distorted); }

 private:
  S k1_, k2_, p1_, p2_, k3_;
  S q_max_;  ///< r_max^2
};

static_assert(CameraModel<Pinhole<float, RadTan>> && CameraModel<Pinhole<double, RadTan>>);

}  // namespace plumbline
