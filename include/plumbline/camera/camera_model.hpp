#pragma once
/// The concept of a central camera.                                                        docs/math/camera.md
///
/// `project` maps a point in the camera frame [m] (x right, y down, z forward) to a pixel [px] with its 2x3 derivative
/// [px/m]; `valid` is false off the model's domain and for NaN, and then nothing else may be read.
/// `unproject` maps a pixel to the UNIT bearing; `valid` is false where the model has no inverse.

#include <cmath>
#include <concepts>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S>
struct Projection {
  bool valid;
  Vec<S, 2> uv;         ///< [px]
  Mat<S, 2, 3> J_uv_p;  ///< [px/m]
};

template <std::floating_point S>
struct Unprojection {
  bool valid;
  Vec<S, 3> bearing;  ///< unit length
};

template <class C>
concept Projects = requires(const C& camera, const Vec<typename C::Scalar, 3>& p_cam) {
  { camera.project(p_cam) } -> std::same_as<Projection<typename C::Scalar>>;
};

template <class C>
concept Unprojects = requires(const C& camera, const Vec<typename C::Scalar, 2>& uv) {
  { camera.unproject(uv) } -> std::same_as<Unprojection<typename C::Scalar>>;
};

template <class C>
concept CameraModel = std::floating_point<typename C::Scalar> && Projects<C> && Unprojects<C>;

/// d bearing / d uv, 3x2 [rad/px], of every central model: J_b = J_pi^T (J_pi J_pi^T)^-1 with J_pi at the unit bearing.
template <class S>
Mat<S, 3, 2> bearing_jacobian(const Mat<S, 2, 3>& J_uv_bearing) {
  const Mat<S, 2, 2> JJt = product_transposed(J_uv_bearing, J_uv_bearing);
  const S det = JJt(0, 0) * JJt(1, 1) - JJt(0, 1) * JJt(1, 0);
  Mat<S, 3, 2> out;
  for (int i = 0; i < 3; ++i) {
    out(i, 0) = (JJt(1, 1) * J_uv_bearing(0, i) - JJt(0, 1) * J_uv_bearing(1, i)) / det;
    out(i, 1) = (JJt(0, 0) * J_uv_bearing(1, i) - JJt(1, 0) * J_uv_bearing(0, i)) / det;
  }
  return out;
}

/// f_eff = 1/|J_b|_2 on the optical axis [px/rad]: the unit conversion between angles and pixels of this camera.
template <CameraModel Camera>
typename Camera::Scalar effective_focal_length(const Camera& camera) {
  using S = typename Camera::Scalar;
  const Mat<S, 2, 2> J = block<2, 2>(camera.project(Vec<S, 3>(0, 0, 1)).J_uv_p, 0, 0);
  const Mat<S, 2, 2> M = product_transposed(J, J);  // its smallest eigenvalue is 1/|J_b|^2
  const S half_trace = (M(0, 0) + M(1, 1)) / 2, half_gap = (M(0, 0) - M(1, 1)) / 2;
  return std::sqrt(half_trace - std::sqrt(half_gap * half_gap + M(0, 1) * M(1, 0)));
}

}  // namespace plumbline
