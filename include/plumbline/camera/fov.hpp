#pragma once
/// Field-of-view lens distortion (FOV, ATAN), a policy of Pinhole.                          docs/math/camera.md
///
///   r = |m|,  t = tan(w/2),  r' = atan(2 t r)/w,  m' = (r'/r) m                                             (17)
///   J = (r'/r) I + m m^T/r^2 (dr'/dr - r'/r),  dr'/dr = 2 t/(w (1 + 4 t^2 r^2))                              (18)
///   r = tan(w r')/(2 t), valid for w r' < pi/2                                                              (19)

#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// Written `Pinhole<float, Fov>{fx, fy, cx, cy, {w}}`, 0 <= w < pi [rad]; 0 is no distortion.
template <std::floating_point S>
class Fov {
 public:
  using Distorted = typename NoDistortion<S>::Distorted;

  Fov() : Fov(0) {}
  Fov(S w) : w_(w), two_t_(2 * elementary::tan(w / 2)) {}

  S w() const { return w_; }

  /// m' and d m' / d m.
  Distorted distort(const Vec<S, 2>& m) const {
    const S q = squared_norm(m), r = std::sqrt(q);
    if (w_ < tiny || !(r > tiny)) return scaled(m, w_ < tiny ? S(1) : two_t_ / w_);
    const S a = two_t_ * r;
    return radial(m, q, elementary::atan2(a, S(1)) / (w_ * r), two_t_ / (w_ * (1 + a * a)));  // (17), (18)
  }

  /// m and d m / d m'.
  Distorted undistort(const Vec<S, 2>& m_distorted) const {
    const S q = squared_norm(m_distorted), r = std::sqrt(q);
    if (w_ < tiny || !(r > tiny)) return scaled(m_distorted, w_ < tiny ? S(1) : w_ / two_t_);
    const S angle = w_ * r;
    if (!(angle < std::numbers::pi_v<S> / 2)) return {false, m_distorted, identity<S, 2>()};
    const S tangent = elementary::tan(angle);
    return radial(m_distorted, q, tangent / (two_t_ * r), w_ / two_t_ * (1 + tangent * tangent));  // (19)
  }

 private:
  static constexpr S tiny = S(1e-8);

  /// Near the center, and without distortion; invalid for NaN and infinity.
  static Distorted scaled(const Vec<S, 2>& m, S factor) {
    return {squared_norm(m) <= std::numeric_limits<S>::max(), m * factor, identity<S, 2>() * factor};
  }
  /// `ratio` of the radii, `slope` of one by the other.
  static Distorted radial(const Vec<S, 2>& m, S q, S ratio, S slope) {
    Distorted out;
    out.valid = q <= std::numeric_limits<S>::max();
    out.m = m * ratio;
    const S x = m.x(), y = m.y(), c = (slope - ratio) / q;
    out.J << ratio + c * x * x, c * x * y, c * x * y, ratio + c * y * y;
    return out;
  }

  S w_, two_t_;
};

static_assert(CameraModel<Pinhole<float, Fov>> && CameraModel<Pinhole<double, Fov>>);

}  // namespace plumbline
