#pragma once
/// Concept of a map, and the map that stores nothing. A map stores what leaves the backend, and gives the transform to
/// the map frame, in which loops are closed:
///
///   map.retire(retired)     a frame with its landmarks, see Retired
///   map.T_map_odom()        correction of the drift of the estimator's world; the estimate itself does not jump
///
/// NoMap is the default policy: no state, no code.

#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Map policy: what leaves the backend is discarded.
struct NoMap {
  template <class S>
  struct Discard {
    void retire(const auto& /*retired*/) {}
    static SE3<S> T_map_odom() { return {}; }
  };
  template <class Sensors>
  using Map = Discard<typename Sensors::Scalar>;
};

}  // namespace plumbline
