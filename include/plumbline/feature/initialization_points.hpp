#pragma once
/// Feature kind: corner points for the initialization of a camera without depth, at most N landmarks. They give the
/// relative pose of the first views, which lines alone do not determine, and are removed when the other kinds are
/// located. Options: `options.initialization_points`.

#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <int N, template <class> class Loss = Huber>
struct InitializationPoints {
  static_assert(N >= 8, "plumbline: two views need eight points");
  static constexpr int capacity = N;

  template <SensorRig Sensors>
  using Kind = PointKind<Sensors, Loss>;

  template <class Options>
  struct Named {
    Options initialization_points;
  };
  static auto& options_of(auto& all) { return all.initialization_points; }
};

}  // namespace plumbline
