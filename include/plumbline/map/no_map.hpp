#pragma once
/// No map, the default policy: what leaves the window is discarded. No state, no code.

#include "plumbline/lie/sim3.hpp"

namespace plumbline {

struct NoMap {
  struct Options {};
  template <class S>
  struct Discard {
    Discard() = default;
    Discard(const auto& /*rig*/, const Options&) {}
    static void on_keyframe(const auto& /*keyframe*/) {}
    static void on_retired(const auto& /*retired*/) {}
    static void on_world_change(const auto& /*change*/) {}
    static void work() {}
    static Sim3<S> S_map_world() { return {}; }
  };
  template <class Parts>
  using Map = Discard<typename Parts::S>;
};

}  // namespace plumbline
