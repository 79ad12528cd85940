#pragma once
/// Where the blocks stand in a vector, one after the other in the order of their names: computed, never written down.
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

  /// Of the block's first number.
  template <class Block>
  static constexpr int offset = [] {
    static_assert(has<Block>, "plumbline: this state has no such block");
    int sum = 0;
    bool found = false;
    ((found = found || std::is_same_v<Block, Blocks>, sum += found ? 0 : Blocks::dim), ...);
    return sum;
  }();
};

/// What a frame of a camera alone has.
using VisualLayout = Layout<state::Pose>;
/// What leads in the state of a frame that moves.
using MovingLayout = Layout<state::Pose, state::Velocity>;
/// What a frame of a rig with an IMU has.                                                       docs/math/imu.md (1)
using InertialLayout = Layout<state::Pose, state::Velocity, state::GyroBias, state::AccelBias>;

/// What is estimated of the rig with such frames: where the camera sits and how its clock goes, on a body that readings
/// move.
template <class L>
using RigLayout =
    std::conditional_t<L::template has<state::Velocity>, Layout<state::Extrinsics, state::TimeOffset>, Layout<>>;
template <class L>
constexpr bool has_extrinsics = RigLayout<L>::template has<state::Extrinsics>;
template <class L>
constexpr bool has_time_offset = RigLayout<L>::template has<state::TimeOffset>;

static_assert(InertialLayout::dim == 15 && InertialLayout::offset<state::GyroBias> == 9);

}  // namespace plumbline
