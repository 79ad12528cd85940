#pragma once
/// Feature kind: corner points that a camera without depth begins with, at most N landmarks. They tell how the first
/// views stand to one another, which lines alone do not, and are given up as soon as the other kinds carry the
/// estimate. Options: `options.start_points`.

#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <int N, template <class> class Loss = Huber>
struct StartPoints {
  static_assert(N >= 8, "plumbline: two views need eight points");
  static constexpr int capacity = N;

  template <SensorRig Sensors>
  using Kind = PointKind<Sensors, Loss>;

  template <class Options>
  struct Named {
    Options start_points;
  };
  static auto& options_of(auto& all) { return all.start_points; }
};

}  // namespace plumbline
