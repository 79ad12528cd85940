#pragma once
/// Feature kind: corner points, at most N landmarks in the map.

#include "plumbline/feature/point_map.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <int N>
struct Points {
  static_assert(N >= 8, "plumbline: fewer than eight points carry no estimate");

  template <SensorRig Sensors, int Slots>
  using Map = PointMap<Sensors, N, Slots>;
};

}  // namespace plumbline
