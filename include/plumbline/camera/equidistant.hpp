#pragma once
/// Equidistant fisheye camera with a polynomial (Kannala-Brandt).                          docs/math/camera.md
///
///   r = |(x, y)|,  th = atan2(r, z),  th_d = th (1 + k1 th^2 + k2 th^4 + k3 th^6 + k4 th^8),  s = th_d / r   (6)
///   uv = (fx s x + cx, fy s y + cy),  J_uv_p = diag(fx, fy) ([s I, 0] + (x, y) ds)                           (7)
///   ds = (x/r, y/r, 0) (th_d' z / (r |p|^2) - th_d / r^2) - e3 th_d' / |p|^2                                 (8)
/// Valid for th < th_max: th_d grows up to there, and th_max <= pi.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/camera/monotone_limit.hpp"
#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S>
class Equidistant {
 public:
  using Scalar = S;
  S fx, fy, cx, cy;  ///< [px]

  Equidistant(S focal_x, S focal_y, S center_x, S center_y, S k1 = 0, S k2 = 0, S k3 = 0, S k4 = 0)
      : fx(focal_x),
        fy(focal_y),
        cx(center_x),
        cy(center_y),
        k1_(k1),
        k2_(k2),
        k3_(k3),
        k4_(k4),
        theta_max_(std::sqrt(
            monotone_limit<S, 4>({3 * k1, 5 * k2, 7 * k3, 9 * k4}, std::numbers::pi_v<S> * std::numbers::pi_v<S>))) {}

  S k1() const { return k1_; }
  S k2() const { return k2_; }
  S k3() const { return k3_; }
  S k4() const { return k4_; }
  S theta_max() const { return theta_max_; }  ///< [rad] from the optical axis

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    Projection<S> out;
    const Vec<S, 2> xy = p_cam.template head<2>();
    const S z = p_cam.z(), r = norm(xy), range2 = squared_norm(p_cam);
    const S theta = elementary::atan2(r, z);
    out.valid = theta < theta_max_ && range2 > tiny * tiny;  // false for NaN too
    if (!out.valid) return out;
    S s = 1 / z;
    Vec<S, 3> ds(0, 0, 0);  // its products with x and y vanish on the axis
    if (r > tiny * z) {
      const Angle distorted = distort(theta);
      s = distorted.value / r;
      ds << xy * ((distorted.derivative * z / range2 - s) / (r * r)), -distorted.derivative / range2;  // (8)
    }
    out.uv << fx * s * xy.x() + cx, fy * s * xy.y() + cy;                                  // (7)
    out.J_uv_p << fx * (s + xy.x() * ds.x()), fx * xy.x() * ds.y(), fx * xy.x() * ds.z(),  //
        fy * xy.y() * ds.x(), fy * (s + xy.y() * ds.y()), fy * xy.y() * ds.z();
    return out;
  }

  /// Newton's method on th_d(th) = |m'|, m' = ((u - cx)/fx, (v - cy)/fy).
  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    Unprojection<S> out;
    out.valid = false;
    const Vec<S, 2> m((uv.x() - cx) / fx, (uv.y() - cy) / fy);
    const S radius = norm(m);
    if (!(radius < distort(theta_max_).value)) return out;  // th_d is increasing: inside, the root exists
    if (radius < tiny) {
      out.valid = true;
      out.bearing = normalized(Vec<S, 3>(m.x(), m.y(), S(1)));
      return out;
    }
    S low = 0, high = theta_max_, theta = std::min(radius, theta_max_ / 2);
    for (int iteration = 0; iteration < 40; ++iteration) {  // a step out of the bracket becomes a bisection
      const Angle distorted = distort(theta);
      (distorted.value < radius ? low : high) = theta;
      S next = theta + (radius - distorted.value) / distorted.derivative;
      if (!(next > low && next < high)) next = low + (high - low) / 2;
      const S step = std::abs(next - theta);
      theta = next;
      if (step <= 4 * std::numeric_limits<S>::epsilon() * theta) break;
    }
    out.valid = true;
    out.bearing << m * (elementary::sin(theta) / radius), elementary::cos(theta);
    return out;
  }

 private:
  static constexpr S tiny = S(1e-8);
  struct Angle {
    S value, derivative;
  };
  /// th_d and d th_d / d th of (6).
  Angle distort(S theta) const {
    const S t = theta * theta;
    return {theta * (1 + t * (k1_ + t * (k2_ + t * (k3_ + t * k4_)))),
            1 + t * (3 * k1_ + t * (5 * k2_ + t * (7 * k3_ + t * 9 * k4_)))};
  }

  S k1_, k2_, k3_, k4_;
  S theta_max_;
};

static_assert(CameraModel<Equidistant<float>> && CameraModel<Equidistant<double>>);

}  // namespace plumbline
