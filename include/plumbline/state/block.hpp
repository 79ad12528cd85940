#pragma once
/// Blocks of the state: the quantities that are estimated, each named by a type, of a frame and of the rig.
///
/// A block has a value type and a dimension, that of its increment (docs/conventions.md). Its offset in a vector is
/// given by a Layout (state/layout.hpp).

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

// Blocks of a frame.
struct Pose : detail::Transform {};       ///< T_world_body
struct Velocity : detail::Vector<3> {};   ///< v_world_body [m/s]
struct GyroBias : detail::Vector<3> {};   ///< [rad/s]
struct AccelBias : detail::Vector<3> {};  ///< [m/s^2]

// Blocks of the rig.
struct Extrinsics : detail::Transform {};  ///< T_body_cam
struct TimeOffset : detail::Vector<1> {};  ///< t_imu = t_image + offset [s]

}  // namespace plumbline::state
