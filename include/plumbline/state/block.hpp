#pragma once
/// What is estimated, block by block and by name: those of a frame, and those of the rig. A block has a value, and a
/// dimension, that of its increment (docs/conventions.md); where it stands in a vector is for its Layout to say.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::state {

namespace detail {
template <int Dim>
struct Vector {
  static constexpr int dim = Dim;
  template <class S>
  using Value = Vec<S, Dim>;
};
struct Transform {
  static constexpr int dim = 6;
  template <class S>
  using Value = SE3<S>;
};
}  // namespace detail

// Of a frame.
struct Pose : detail::Transform {};       ///< T_world_body
struct Velocity : detail::Vector<3> {};   ///< v_world_body [m/s]
struct GyroBias : detail::Vector<3> {};   ///< [rad/s]
struct AccelBias : detail::Vector<3> {};  ///< [m/s^2]

// Of the rig.
struct Extrinsics : detail::Transform {};  ///< T_body_cam
struct TimeOffset : detail::Vector<1> {};  ///< of the camera's clock: time of the IMU = time of the image + offset [s]

}  // namespace plumbline::state
