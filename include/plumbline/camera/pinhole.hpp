#pragma once
/// Pinhole camera with an optional lens distortion.                                        docs/math/camera.md
///
///   m = (x/z, y/z),  uv = (fx m'x + cx, fy m'y + cy),  m' = distort(m)                                       (1)
///   J_uv_p = diag(fx, fy) J_m'_m [1/z 0 -x/z^2; 0 1/z -y/z^2]                                                (2)
/// Valid for z > z_min and m in the domain of the distortion.

#include <concepts>
#include <limits>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// No distortion: the identity on the z = 1 plane. A distortion policy has these two members and this result type; both
/// are invalid for NaN.
template <std::floating_point S>
struct NoDistortion {
  struct Distorted {
    bool valid;
    Vec<S, 2> m;
    Mat<S, 2, 2> J;  ///< derivative of this m by the argument
  };
  Distorted distort(const Vec<S, 2>& m) const {
    return {squared_norm(m) <= std::numeric_limits<S>::max(), m, identity<S, 2>()};  // false for NaN and infinity
  }
  Distorted undistort(const Vec<S, 2>& m_distorted) const { return distort(m_distorted); }
};

template <std::floating_point S, template <class> class Distortion = NoDistortion>
struct Pinhole {
  using Scalar = S;
  static constexpr S z_min = S(1e-3);  ///< [m]

  S fx, fy, cx, cy;  ///< [px]
  [[no_unique_address]] Distortion<S> distortion{};

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    Projection<S> out;
    out.valid = p_cam.z() > z_min;  // false for NaN too
    if (!out.valid) return out;
    const S iz = S(1) / p_cam.z();
    const Vec<S, 2> m(p_cam.x() * iz, p_cam.y() * iz);
    const auto distorted = distortion.distort(m);
    out.valid = distorted.valid;
    out.uv = Vec<S, 2>(fx * distorted.m.x() + cx, fy * distorted.m.y() + cy);  // (1)
    for (int r = 0; r < 2; ++r) {                                              // (2)
      const S scale = (r == 0 ? fx : fy) * iz, J_0 = scale * distorted.J(r, 0), J_1 = scale * distorted.J(r, 1);
      out.J_uv_p(r, 0) = J_0;
      out.J_uv_p(r, 1) = J_1;
      out.J_uv_p(r, 2) = -(J_0 * m.x() + J_1 * m.y());
    }
    return out;
  }

  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    const auto undistorted = distortion.undistort(Vec<S, 2>((uv.x() - cx) / fx, (uv.y() - cy) / fy));
    Unprojection<S> out;
    out.valid = undistorted.valid;
    if (!out.valid) return out;
    out.bearing = normalized(Vec<S, 3>(undistorted.m.x(), undistorted.m.y(), S(1)));
    return out;
  }
};

static_assert(CameraModel<Pinhole<float>> && CameraModel<Pinhole<double>>);
static_assert(!CameraModel<Vec<float, 3>>);  // the failing twin guards the concept itself
static_assert(sizeof(Pinhole<float>) == 4 * sizeof(float));

}  // namespace plumbline
