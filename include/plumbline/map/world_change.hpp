#pragma once
/// A change of the world frame or of the unit of length in which the poses of the window are given.

#include <cstdint>

#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"

namespace plumbline {

template <class S>
struct WorldChange {
  enum class Kind : std::uint8_t {
    transformed,  ///< x_new = S_new_old x_old: vision was aligned with the IMU; the world is metric and upright now
    rejected,     ///< the initialization was wrong: what was learned since the last `reset` is to be discarded
    reset,        ///< the window is cleared, all its keyframes were retired before; the next one is in a new world
  };

  Kind kind;
  Sim3<S> S_new_old = {};
  /// Of `transformed`: extrinsics in force from now on. Before initialization the body of a rig with an IMU is in the
  /// camera, turned; it is the cameras that S_new_old moves.
  SE3<S> T_body_cam = {};
};

}  // namespace plumbline
