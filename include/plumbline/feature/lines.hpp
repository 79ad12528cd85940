#pragma once
/// Feature kind: straight edges, at most N landmarks in the map. Detector finds new ones, e.g. opencv::LsdDetector<>.

#include "plumbline/feature/line_map.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/line_detector.hpp"

namespace plumbline {

template <int N, LineDetector Detector = LineSegmentDetector<>>
struct Lines {
  static_assert(N >= 8, "plumbline: fewer than eight lines carry no estimate");

  template <SensorRig Sensors, int Slots>
  using Map = LineMap<Sensors, N, Slots, Detector>;
};

}  // namespace plumbline
