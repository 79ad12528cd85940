#pragma once
/// Extended unified camera model; projection and inverse in closed form.                   docs/math/camera.md
///
///   d = sqrt(beta (x^2 + y^2) + z^2),  N = alpha d + (1 - alpha) z,  uv = (fx x/N + cx, fy y/N + cy)          (24)
///   J_uv_p = diag(fx, fy) ([I, 0]/N - (x, y) dN/N^2),  dN = alpha (beta x, beta y, z)/d + (1 - alpha) e3      (25)
///   valid for z > -w d,  w = alpha <= 1/2 ? alpha/(1 - alpha) : (1 - alpha)/alpha                            (26)
///   bearing ~ (m, mz),  mz = (1 - beta alpha^2 q)/(alpha sqrt(1 - (2 alpha - 1) beta q) + 1 - alpha),  q = |m|^2  (27)

#include <cmath>
#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// 0 <= alpha <= 1, beta > 0.
template <std::floating_point S>
class Eucm {
 public:
  using Scalar = S;
  S fx, fy, cx, cy;  ///< [px]

  Eucm(S focal_x, S focal_y, S center_x, S center_y, S alpha, S beta)
      : fx(focal_x),
        fy(focal_y),
        cx(center_x),
        cy(center_y),
        alpha_(alpha),
        beta_(beta),
        w_(alpha <= S(0.5) ? alpha / (1 - alpha) : (1 - alpha) / alpha) {}

  S alpha() const { return alpha_; }
  S beta() const { return beta_; }

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    Projection<S> out;
    const S x = p_cam.x(), y = p_cam.y(), z = p_cam.z();
    const S d = std::sqrt(beta_ * (x * x + y * y) + z * z);
    out.valid = z > -w_ * d && d > S(1e-8);  // (26), false for NaN too
    if (!out.valid) return out;
    const S N = alpha_ * d + (1 - alpha_) * z;
    out.valid = N > 0;
    if (!out.valid) return out;
    const S iN = 1 / N, along = alpha_ / d;
    out.uv << fx * x * iN + cx, fy * y * iN + cy;  // (24)
    const Vec<S, 3> g = Vec<S, 3>(along * beta_ * x, along * beta_ * y, along * z + 1 - alpha_) * (iN * iN);
    out.J_uv_p << fx * (iN - x * g.x()), -fx * x * g.y(), -fx * x * g.z(),  // (25)
        -fy * y * g.x(), fy * (iN - y * g.y()), -fy * y * g.z();
    return out;
  }

  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    Unprojection<S> out;
    const S mx = (uv.x() - cx) / fx, my = (uv.y() - cy) / fy, q = beta_ * (mx * mx + my * my);
    const S under_root = 1 - (2 * alpha_ - 1) * q;
    out.valid = under_root >= 0 && std::isfinite(q);
    if (!out.valid) return out;
    const S mz = (1 - alpha_ * alpha_ * q) / (alpha_ * std::sqrt(under_root) + 1 - alpha_);
    out.bearing = normalized(Vec<S, 3>(mx, my, mz));  // (27)
    return out;
  }

 private:
  S alpha_, beta_;
  S w_;  ///< of (26)
};

static_assert(CameraModel<Eucm<float>> && CameraModel<Eucm<double>>);

}  // namespace plumbline
