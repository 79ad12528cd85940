#pragma once
/// Feature kind: straight edges, at most N landmarks in the map.

#include "plumbline/feature/line_map.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <int N>
struct Lines {
  static_assert(N >= 8, "plumbline: fewer than eight lines carry no estimate");

  template <SensorRig Sensors, int Slots>
  using Map = LineMap<Sensors, N, Slots>;
};

}  // namespace plumbline
