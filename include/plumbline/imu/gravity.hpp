#pragma once
/// Gravity, and the attitude it gives.                                                docs/math/initialization.md
///
///   g = (0, 0, -G) in the world: the acceleration of free fall; an accelerometer at rest reads -g               (1)
///   R_world_body = [x^T; (u x x)^T; u^T],  u = -g_body/|g_body|,  x = heading axis made horizontal              (2)
/// The heading axis is the body's x, or its z where x is closer than 45 degrees to the vertical: it has no yaw.

#include <Eigen/Geometry>
#include <cmath>
#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
inline constexpr S standard_gravity = S(9.81);  ///< G [m/s^2]

/// (1)
template <std::floating_point S>
Vec<S, 3> gravity_in_world(S magnitude = standard_gravity<S>) {
  return {S(0), S(0), -magnitude};
}

/// (2), from the direction of gravity in the body frame, any length but zero.
template <std::floating_point S>
SO3<S> upright(const Vec<S, 3>& gravity_body) {
  const Vec<S, 3> up = -gravity_body.normalized();
  const Vec<S, 3> axis = Vec<S, 3>::Unit(std::abs(up.x()) < S(0.7071) ? 0 : 2);
  const Vec<S, 3> x = (axis - axis.dot(up) * up).normalized();
  Mat<S, 3, 3> R_world_body;
  R_world_body << x.transpose(), up.cross(x).transpose(), up.transpose();
  return SO3<S>::from_matrix(R_world_body);
}

}  // namespace plumbline
