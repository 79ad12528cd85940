#pragma once
/// Feature kind: corner points, at most N landmarks, with a robust loss. Options: `options.points`.

#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <int N, template <class> class Loss = Huber>
struct Points {
  static_assert(N >= 8, "plumbline: fewer than eight points carry no estimate");
  static constexpr int capacity = N;

  template <SensorRig Sensors>
  using Kind = PointKind<Sensors, Loss>;

  template <class Options>
  struct Named {
    Options points;
  };
  static auto& options_of(auto& all) { return all.points; }
};

}  // namespace plumbline
