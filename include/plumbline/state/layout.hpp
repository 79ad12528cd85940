#pragma once
/// Offsets of blocks in a vector: the blocks stand one after the other in the order of the template arguments.
///
///   using Motion = Layout<state::Pose, state::Velocity>;
///   Motion::dim == 9, Motion::offset<state::Velocity> == 6

#include <type_traits>

#include "plumbline/state/block.hpp"

namespace plumbline {

template <class... Blocks>
struct Layout {
  static constexpr int dim = (0 + ... + Blocks::dim);

  template <class Block>
  static constexpr bool has = (false || ... || std::is_same_v<Block, Blocks>);

  /// Index of the block's first number.
  template <class Block>
  static constexpr int offset = [] {
    static_assert(has<Block>, "plumbline: this state has no such block");
    int sum = 0;
    bool found = false;
    ((found = found || std::is_same_v<Block, Blocks>, sum += found ? 0 : Blocks::dim), ...);
    return sum;
  }();
};

/// Blocks of a frame without an IMU.
using VisualLayout = Layout<state::Pose>;
/// Leading blocks of a frame with a velocity.
using MovingLayout = Layout<state::Pose, state::Velocity>;
/// Blocks of a frame of a rig with an IMU.                                                      docs/math/imu.md (1)
using InertialLayout = Layout<state::Pose, state::Velocity, state::GyroBias, state::AccelBias>;

/// Blocks of the rig that are estimated with frames of layout L: extrinsics and time offset with an IMU, else none.
template <class L>
using RigLayout =
    std::conditional_t<L::template has<state::Velocity>, Layout<state::Extrinsics, state::TimeOffset>, Layout<>>;
template <class L>
constexpr bool has_extrinsics = RigLayout<L>::template has<state::Extrinsics>;
template <class L>
constexpr bool has_time_offset = RigLayout<L>::template has<state::TimeOffset>;

static_assert(InertialLayout::dim == 15 && InertialLayout::offset<state::GyroBias> == 9);

}  // namespace plumbline
