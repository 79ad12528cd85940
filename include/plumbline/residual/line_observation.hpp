#pragma once
/// Residuals of a line in the camera that measures it, by its Pluecker coordinates (n, v) in that camera.
///                                                                                          docs/math/line.md
///   endpoints      r_i = k_i nh . b_i,  nh = n/|n|                 2x1 [px]                                   (9)
///                  J_r_n = k_i/|n| (b_i - (nh . b_i) nh)^T         2x3;  J_r_v = 0
///                  k_i = 1/|J_b^T mh|,  mh = (b_0 x b_1)/|b_0 x b_1|,  J_b = d bearing/d uv     [px/rad]      (10)
///   inverse depth  r_i = q . m_i - 1/z_i,  q = v x n/|n|^2         2x1 [1/m], m_i = b_i/b_iz                  (11)
///                  J_r_n = (m_i x v - 2 (q . m_i) n)^T/|n|^2,  J_r_v = (n x m_i)^T/|n|^2        2x3, 2x3
/// (9) is the distance of the measured endpoints to the projected line, to first order in pixels, for every central
/// camera; the position of an endpoint ALONG the line is not a measurement. (11) is the inverse depth of the line on
/// the ray; 1/z is affine along a segment, so two values contain all information of a depth image.
///
/// Not valid if the line passes the camera center within 2 cm (its image degenerates to a point), or if the observed
/// part would be behind the camera.

#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

/// A residual as a function of the line in the observing camera.
template <class S, int Rows>
struct CameraLineLinearization {
  bool valid;
  Vec<S, Rows> r;
  Mat<S, Rows, 3> J_r_n;
  Mat<S, Rows, 3> J_r_v;
};

/// Whether the line is more than 2 cm from the camera center and in front of the camera at `bearing`; false for NaN.
template <class S>
bool line_visible(const Plucker<S>& line, const Vec<S, 3>& bearing) {
  constexpr S distance_min = S(0.02);  // [m]
  return squared_norm(line.n) > distance_min * distance_min * squared_norm(line.v) &&
         dot(bearing, line.v.cross(line.n)) > S(0);
}

/// (a^T; b^T)
template <class S>
Mat<S, 2, 3> rows(const Vec<S, 3>& a, const Vec<S, 3>& b) {
  Mat<S, 2, 3> out;
  out << a[0], a[1], a[2], b[0], b[1], b[2];
  return out;
}

/// Measured endpoints, (9).
template <std::floating_point S>
struct LineReprojection {
  using Scalar = S;
  static constexpr int dim = 2;
  using Linearized = CameraLineLinearization<S, dim>;

  Vec<S, 3> bearing_start, bearing_end;  ///< of the measured endpoints, unit
  Vec<S, 2> px_per_rad;                  ///< (10), of start and end

  Vec<S, 2> residual(const Plucker<S>& line) const {
    const Vec<S, 3> nh = normalized(line.n);
    return {px_per_rad[0] * dot(nh, bearing_start), px_per_rad[1] * dot(nh, bearing_end)};
  }

  Linearized linearize(const Plucker<S>& line) const {
    Linearized out;
    out.valid = line_visible<S>(line, bearing_start + bearing_end);
    if (!out.valid) return out;
    const S inverse_norm = S(1) / norm(line.n);
    const Vec<S, 3> nh = line.n * inverse_norm;
    const S e_start = dot(nh, bearing_start), e_end = dot(nh, bearing_end);
    out.r << px_per_rad[0] * e_start, px_per_rad[1] * e_end;
    out.J_r_n = rows<S>((px_per_rad[0] * inverse_norm) * (bearing_start - e_start * nh),
                        (px_per_rad[1] * inverse_norm) * (bearing_end - e_end * nh));
    set_zero(out.J_r_v);
    return out;
  }
};

/// A measured segment; `valid` is false where the camera has no rays at its ends, or when they coincide.
template <class S>
struct LineObservation {
  bool valid = false;
  LineReprojection<S> reprojection;
};

/// The measurement of the segment between two pixels.
template <CameraModel Camera>
LineObservation<typename Camera::Scalar> observe_line(const Camera& camera,
                                                      const Vec<typename Camera::Scalar, 2>& uv_start,
                                                      const Vec<typename Camera::Scalar, 2>& uv_end) {
  using S = typename Camera::Scalar;
  LineObservation<S> out;
  const Unprojection<S> start = camera.unproject(uv_start), end = camera.unproject(uv_end);
  if (!start.valid || !end.valid) return out;
  const Projection<S> at_start = camera.project(start.bearing), at_end = camera.project(end.bearing);
  const Vec<S, 3> m = start.bearing.cross(end.bearing);
  const S m_norm = norm(m);
  out.valid = at_start.valid && at_end.valid && m_norm > S(0);
  if (!out.valid) return out;
  const Vec<S, 3> mh = m / m_norm;
  out.reprojection.bearing_start = start.bearing;
  out.reprojection.bearing_end = end.bearing;
  const Mat<S, 1, 3> across(mh[0], mh[1], mh[2]);
  const auto px_per_rad = [&](const Mat<S, 2, 3>& J_uv_bearing) {
    const Mat<S, 1, 2> rad_per_px = product(across, bearing_jacobian(J_uv_bearing));
    return S(1) / elementary::hypot(rad_per_px[0], rad_per_px[1]);
  };
  out.reprojection.px_per_rad << px_per_rad(at_start.J_uv_p), px_per_rad(at_end.J_uv_p);  // (10)
  return out;
}

/// Measured inverse depths, (11).
template <std::floating_point S>
struct LineInverseDepth {
  using Scalar = S;
  static constexpr int dim = 2;
  using Linearized = CameraLineLinearization<S, dim>;

  Vec<S, 3> m_start, m_end;          ///< rays to the endpoints with z = 1
  Vec<S, 2> inverse_depth_measured;  ///< 1/z there [1/m]

  Vec<S, 2> residual(const Plucker<S>& line) const {
    const Vec<S, 3> q = line.facing_plane();
    return Vec<S, 2>(dot(q, m_start), dot(q, m_end)) - inverse_depth_measured;
  }

  Linearized linearize(const Plucker<S>& line) const {
    Linearized out;
    out.valid = line_visible<S>(line, m_start + m_end);
    if (!out.valid) return out;
    const S inverse_square = S(1) / squared_norm(line.n);
    const Vec<S, 3> q = line.facing_plane();
    const Vec<S, 2> predicted(dot(q, m_start), dot(q, m_end));
    out.r = predicted - inverse_depth_measured;
    out.J_r_n = rows<S>(inverse_square * (m_start.cross(line.v) - 2 * predicted[0] * line.n),
                        inverse_square * (m_end.cross(line.v) - 2 * predicted[1] * line.n));
    out.J_r_v = rows<S>(inverse_square * line.n.cross(m_start), inverse_square * line.n.cross(m_end));
    return out;
  }
};

static_assert(Residual<LineReprojection<float>> && Residual<LineInverseDepth<double>>);

/// Jacobian by the pose of the observing body, T_world_body; (n, v) is the line in its camera.                 (12)
///   [J_r_n [n]x + J_r_v [v]x, J_r_n [v]x] [R_e^T, 0; -R_e^T [p_e]x, R_e^T],   T_body_cam = (R_e, p_e)
template <class S, int Rows>
Mat<S, Rows, 6> line_pose_jacobian(const CameraLineLinearization<S, Rows>& lin, const Plucker<S>& line,
                                   const Mat<S, 3, 3>& R_cam_body, const Vec<S, 3>& p_body_cam) {
  const Mat<S, Rows, 3> J_p = product(product_hat(lin.J_r_n, line.v), R_cam_body);
  Mat<S, Rows, 3> J_cam = product_hat(lin.J_r_n, line.n);
  J_cam += product_hat(lin.J_r_v, line.v);
  Mat<S, Rows, 3> J_phi = product(J_cam, R_cam_body);
  J_phi -= product_hat(J_p, p_body_cam);
  Mat<S, Rows, 6> J;
  set_block(J, 0, 0, J_phi);
  set_block(J, 0, 3, J_p);
  return J;
}

}  // namespace plumbline
