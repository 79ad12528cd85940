#pragma once
/// Gravity in the world, and the attitude of a body from the direction of gravity.    docs/math/initialization.md
///
///   g = (0, 0, -G) in the world: the acceleration of free fall; a stationary accelerometer measures -g            (1)
///   R_world_body = [x^T; (u x x)^T; u^T],  u = -g_body/|g_body|,  x = heading axis made horizontal                (2)
/// The heading axis is the body's x, or its z where x is within 45 degrees of the vertical; it has zero yaw.

#include <Eigen/Geometry>
#include <cmath>
#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
inline constexpr S standard_gravity = S(9.81);  ///< G [m/s^2]; geometry: mid-latitudes

/// (1)
template <std::floating_point S>
Vec<S, 3> gravity_in_world(S magnitude = standard_gravity<S>) {
  return {S(0), S(0), -magnitude};
}

/// R_world_body (2) from gravity in the body frame, of any length but zero.
template <std::floating_point S>
SO3<S> upright(const Vec<S, 3>& gravity_body) {
  const Vec<S, 3> up = -normalized(gravity_body);
  constexpr S cos_45_deg = S(0.7071);  // geometry: x where it is farther than 45 degrees from the vertical
  const Vec<S, 3> axis = std::abs(up.x()) < cos_45_deg ? Vec<S, 3>(1, 0, 0) : Vec<S, 3>(0, 0, 1);
  const Vec<S, 3> x = normalized(axis - dot(axis, up) * up);
  const Vec<S, 3> y = up.cross(x);
  Mat<S, 3, 3> R_world_body;
  for (int k = 0; k < 3; ++k) {
    R_world_body(0, k) = x[k];
    R_world_body(1, k) = y[k];
    R_world_body(2, k) = up[k];
  }
  return SO3<S>::from_matrix(R_world_body);
}

}  // namespace plumbline
