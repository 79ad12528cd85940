#pragma once
/// The mounting of the simulated camera on the body: looking forward, a few centimeters and degrees off.

#include "plumbline/lie/se3.hpp"

namespace plumbline::testing {

/// Camera z forward (body x), x right (-y), y down (-z), turned by about two degrees as on a real rig.
inline SE3<double> simulated_T_body_camera() {
  Mat<double, 3, 3> R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {SO3<double>::from_matrix(R) * SO3<double>::exp({0.017, -0.015, 0.005}), Vec<double, 3>(0.057, 0.024, 0.003)};
}

}  // namespace plumbline::testing
