#pragma once
/// Omnidirectional camera with an optional lens distortion (Mei; Kalibr omni): a point is projected to the unit sphere
/// and
/// from there by a pinhole that is xi behind its center.                                   docs/math/camera.md
///
///   N = z + xi |p|,  m = (x, y)/N,  uv = (fx m'x + cx, fy m'y + cy),  m' = distort(m)                        (20)
///   J_uv_p = diag(fx, fy) J_m'_m ([I, 0] - m dN)/N,  dN = e3 + xi p/|p|                                      (21)
///   valid for z > -w |p|,  w = xi <= 1 ? xi : 1/xi, and m in the domain of the distortion                    (22)
///   bearing = k (m, 1) - xi e3,  k = (xi + sqrt(1 + (1 - xi^2) q))/(1 + q),  q = |m|^2                       (23)

#include <cmath>
#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// Written `Omni<float>{fx, fy, cx, cy, xi, {k1, k2, p1, p2}}`, xi >= 0.
template <std::floating_point S, template <class> class Distortion = RadTan>
struct Omni {
  using Scalar = S;

  S fx, fy, cx, cy;  ///< [px]
  S xi;
  [[no_unique_address]] Distortion<S> distortion{};

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    Projection<S> out;
    const S range = norm(p_cam), w = xi <= 1 ? xi : 1 / xi;
    out.valid = p_cam.z() > -w * range && range > S(1e-8);  // (22), false for NaN too
    if (!out.valid) return out;
    const S iN = 1 / (p_cam.z() + xi * range);
    const Vec<S, 2> m(p_cam.x() * iN, p_cam.y() * iN);
    const auto distorted = distortion.distort(m);
    out.valid = distorted.valid;
    out.uv << fx * distorted.m.x() + cx, fy * distorted.m.y() + cy;  // (20)
    const Vec<S, 3> dN = xi / range * p_cam + Vec<S, 3>(0, 0, 1);
    for (int r = 0; r < 2; ++r) {  // (21)
      const S scale = (r == 0 ? fx : fy) * iN, J_0 = scale * distorted.J(r, 0), J_1 = scale * distorted.J(r, 1);
      const S along = J_0 * m.x() + J_1 * m.y();
      out.J_uv_p(r, 0) = J_0 - along * dN.x();
      out.J_uv_p(r, 1) = J_1 - along * dN.y();
      out.J_uv_p(r, 2) = -along * dN.z();
    }
    return out;
  }

  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    const auto undistorted = distortion.undistort(Vec<S, 2>((uv.x() - cx) / fx, (uv.y() - cy) / fy));
    Unprojection<S> out;
    const Vec<S, 2>& m = undistorted.m;
    const S q = squared_norm(m), under_root = 1 + (1 - xi * xi) * q;
    out.valid = undistorted.valid && under_root >= 0;
    if (!out.valid) return out;
    const S k = (xi + std::sqrt(under_root)) / (1 + q);
    out.bearing << k * m, k - xi;  // (23)
    return out;
  }
};

static_assert(CameraModel<Omni<float>> && CameraModel<Omni<double>>);

}  // namespace plumbline
