#pragma once
/// The map of the program's estimators: a keyframe map if it is asked for, else none. One type serves both, so that
/// each configuration is compiled once.

#include <memory>
#include <utility>

#include "map_timing.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/keyframe_map.hpp"
#include "steady_clock.hpp"

struct OptionalMap {
  using Kept = plumbline::KeyframeMap<500, 200, 40>;
  struct Options {
    bool is_used = false;
    Kept::Options map;
  };

  template <class Sensors>
  class MapOf {
   public:
    using S = typename Sensors::Scalar;

    MapOf(const Sensors& rig, const Options& options)
        : map_(options.is_used ? std::make_unique<Kept::MapOf<Sensors>>(rig, options.map) : nullptr) {}
    void on_keyframe(const auto& keyframe) {
      if (map_) measure(&MapTiming::learn, [&] { map_->on_keyframe(keyframe); });
    }
    void on_retired(const auto& retired) {
      if (map_) measure(&MapTiming::learn, [&] { map_->on_retired(retired); });
    }
    void on_world_change(const plumbline::WorldChange<S>& change) {
      if (map_) measure(&MapTiming::learn, [&] { map_->on_world_change(change); });
    }
    void work() {
      if (map_) measure(stage_of(map_->stage()), [&] { map_->work(); });
    }
    bool find_frame(const auto& view, const plumbline::SO3<S>& R_cur_prev, auto& found) requires
        requires(Kept::MapOf<Sensors>& map) {
      map.find_frame(view, R_cur_prev, found);
    }
    {
      if (!map_) return false;
      bool is_found = false;
      measure(&MapTiming::query, [&] { is_found = map_->find_frame(view, R_cur_prev, found); });
      return is_found;
    }
    plumbline::Sim3<S> S_map_world() const { return map_ ? map_->S_map_world() : plumbline::Sim3<S>(); }
    /// nullptr without a map.
    const Kept::MapOf<Sensors>* get() const { return map_.get(); }
    Kept::MapOf<Sensors>* get() { return map_.get(); }
    /// Since the last call.
    MapTiming take_timing() { return std::exchange(timing_, {}); }

   private:
    using Stage = typename Kept::MapOf<Sensors>::Stage;

    static double MapTiming::*stage_of(Stage stage) {
      switch (stage) {
        case Stage::query: return &MapTiming::query;
        case Stage::verify: return &MapTiming::verify;
        case Stage::solve:
        case Stage::adjust: break;
      }
      return &MapTiming::solve;
    }
    void measure(double MapTiming::*stage, const auto& work) {
      plumbline::Stopwatch<SteadyClock> stopwatch;
      work();
      timing_.*stage += stopwatch.lap();
    }

    std::unique_ptr<Kept::MapOf<Sensors>> map_;
    MapTiming timing_;
  };
  template <class Parts>
  using Map = MapOf<typename Parts::Sensors>;
};
