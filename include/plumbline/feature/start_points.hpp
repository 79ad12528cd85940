#pragma once
/// Feature kind: corner points that a camera without depth begins with, at most N landmarks in the map. They tell how
/// the first views stand to one another, which lines alone do not, and are given up as soon as scale, gravity and
/// velocity are known: from then on the other kinds carry the estimate.

#include "plumbline/feature/point_map.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <SensorRig Sensors, int Capacity, int Slots>
class StartPointMap : public PointMap<Sensors, Capacity, Slots> {
  using Base = PointMap<Sensors, Capacity, Slots>;

 public:
  using Base::Base;

  /// The start is done: no points any more, until `clear`.
  void end_start() {
    Base::clear();
    is_over_ = true;
  }
  void clear() {
    Base::clear();
    is_over_ = false;
  }
  void insert_keyframe(const View<Sensors>& view, const typename Base::Window& window, int slot) {
    if (!is_over_) Base::insert_keyframe(view, window, slot);
  }

 private:
  bool is_over_ = false;
};

template <int N>
struct StartPoints {
  static_assert(N >= 8, "plumbline: two views need eight points");

  template <SensorRig Sensors, int Slots>
  using Map = StartPointMap<Sensors, N, Slots>;
};

}  // namespace plumbline
