#pragma once
/// Feature kind: corner points, at most N landmarks. Options: `options.points`.

#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <int N>
struct Points {
  static_assert(N >= 8, "plumbline: fewer than eight points carry no estimate");
  static constexpr int capacity = N;

  template <SensorRig Sensors>
  using Kind = PointKind<Sensors>;

  template <class Options>
  struct Named {
    Options points;
  };
  static auto& options_of(auto& all) { return all.points; }
};

}  // namespace plumbline
