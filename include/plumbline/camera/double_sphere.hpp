#pragma once
/// Double sphere camera for wide lenses; projection and inverse in closed form.            docs/math/camera.md
///
///   d1 = |p|,  w = xi d1 + z,  d2 = |(x, y, w)|,  N = alpha d2 + (1 - alpha) w,  uv = (fx x/N + cx, fy y/N + cy)  (9)
///   dw = xi p/d1 + e3,  dd2 = ((x, y, 0) + w dw)/d2,  dN = alpha dd2 + (1 - alpha) dw
///   J_uv_p = diag(fx, fy) ([I, 0]/N - (x, y) dN / N^2)                                                       (10)
///   valid for z > -w2 d1                                                                                     (11)
///   bearing = k (m, mz) - xi e3,  mz = (1 - alpha^2 q)/(alpha sqrt(1 - (2 alpha - 1) q) + 1 - alpha),  q = |m|^2,
///       k = (mz xi + sqrt(mz^2 + (1 - xi^2) q))/(mz^2 + q)                                                   (12)

#include <cmath>
#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// -1 < xi < 1, 0 <= alpha <= 1.
template <std::floating_point S>
class DoubleSphere {
 public:
  using Scalar = S;
  S fx, fy, cx, cy;  ///< [px]

  DoubleSphere(S focal_x, S focal_y, S center_x, S center_y, S xi, S alpha)
      : fx(focal_x), fy(focal_y), cx(center_x), cy(center_y), xi_(xi), alpha_(alpha) {
    const S w1 = alpha <= S(0.5) ? alpha / (1 - alpha) : (1 - alpha) / alpha;
    w2_ = (w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1);
  }

  S xi() const { return xi_; }
  S alpha() const { return alpha_; }

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    Projection<S> out;
    const S x = p_cam.x(), y = p_cam.y(), z = p_cam.z();
    const S d1 = norm(p_cam);
    out.valid = z > -w2_ * d1 && d1 > S(1e-8);  // (11), false for NaN too
    if (!out.valid) return out;
    const S w = xi_ * d1 + z, d2 = std::sqrt(x * x + y * y + w * w), N = alpha_ * d2 + (1 - alpha_) * w;
    out.valid = N > 0;
    if (!out.valid) return out;
    const S iN = 1 / N;
    out.uv << fx * x * iN + cx, fy * y * iN + cy;  // (9)
    const Vec<S, 3> dw = xi_ / d1 * p_cam + Vec<S, 3>(0, 0, 1);
    const Vec<S, 3> dN = alpha_ / d2 * (Vec<S, 3>(x, y, 0) + w * dw) + (1 - alpha_) * dw;
    const Vec<S, 3> g = dN * (iN * iN);
    out.J_uv_p << fx * (iN - x * g.x()), -fx * x * g.y(), -fx * x * g.z(),  // (10)
        -fy * y * g.x(), fy * (iN - y * g.y()), -fy * y * g.z();
    return out;
  }

  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    Unprojection<S> out;
    const S mx = (uv.x() - cx) / fx, my = (uv.y() - cy) / fy, q = mx * mx + my * my;
    const S under_root = 1 - (2 * alpha_ - 1) * q;
    out.valid = under_root >= 0 && std::isfinite(q);
    if (!out.valid) return out;
    const S mz = (1 - alpha_ * alpha_ * q) / (alpha_ * std::sqrt(under_root) + 1 - alpha_);
    const S under_second_root = mz * mz + (1 - xi_ * xi_) * q;
    out.valid = under_second_root >= 0;
    if (!out.valid) return out;
    const S k = (mz * xi_ + std::sqrt(under_second_root)) / (mz * mz + q);
    out.bearing << k * mx, k * my, k * mz - xi_;  // (12)
    return out;
  }

 private:
  S xi_, alpha_;
  S w2_;  ///< of (11)
};

static_assert(CameraModel<DoubleSphere<float>> && CameraModel<DoubleSphere<double>>);

}  // namespace plumbline
