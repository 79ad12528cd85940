#pragma once
/// A map remembers what leaves the backend, and says where its own frame, in which loops are closed, is now:
///
///   map.retire(retired)     a frame with its landmarks, see Retired
///   map.T_map_odom()        corrects the estimator's drifting world; the estimate itself never jumps
///
/// NoMap: what leaves is forgotten.

#include <concepts>

#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
struct NoMap {
  void retire(const auto& /*retired*/) {}
  static SE3<S> T_map_odom() { return {}; }
};

/// Policy: remembers nothing.
struct Forgetful {
  template <class Sensors>
  using Map = NoMap<typename Sensors::Scalar>;
};

}  // namespace plumbline
