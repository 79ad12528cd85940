#pragma once
/// No map, the default policy: what leaves the window is discarded. No state, no code.

#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct NoMap {
  template <class S>
  struct Discard {
    Discard() = default;
    explicit Discard(const auto& /*options*/) {}
    static void on_keyframe(const auto& /*keyframe*/) {}
    static void on_retired(const auto& /*retired*/) {}
    static void on_world_change(const auto& /*change*/) {}
    static SE3<S> T_map_world() { return {}; }
  };
  template <class Parts>
  using Map = Discard<typename Parts::S>;
};

}  // namespace plumbline
