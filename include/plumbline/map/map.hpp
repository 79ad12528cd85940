#pragma once
/// Concept of a map: every call that an estimator makes. A map gets
///
///   on_keyframe(AdoptedKeyframe)   a frame has become a keyframe; its image is here, its pose is still the window's
///   on_retired(Retired)            a keyframe leaves the window with its last estimate, in any order of sequence
///   on_world_change(WorldChange)   the world frame or the unit of length changes, or what was learned is wrong
///
/// For one world the order is: on_keyframe of each frame before its on_retired; `transformed` at most once, after which
/// states are metric; `rejected` or `reset` last. Once a frame the map is given time:
///
///   work()          a bounded slice of what is not done yet: query, verification, pose graph
///   S_map_world()   correction of the world: the identity until a place is recognized
///
/// A map policy (MapPolicy) names a map for the parts of an estimator, constructed by Map(rig, map_options):
///   struct Options;   template <class Parts> using Map = ...;

#include <concepts>

#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/adopted_keyframe.hpp"
#include "plumbline/map/retired.hpp"
#include "plumbline/map/world_change.hpp"

namespace plumbline {

template <class M, class Sensors, class Frames, class Landmarks>
concept Map = requires(M& map, const M& known, const AdoptedKeyframe<Frames, Sensors, Landmarks>& keyframe,
                       const Retired<typename Frames::Value, Landmarks>& retired,
                       const WorldChange<typename Sensors::Scalar>& change) {
  map.on_keyframe(keyframe);
  map.on_retired(retired);
  map.on_world_change(change);
  map.work();
  { known.S_map_world() } -> std::convertible_to<Sim3<typename Sensors::Scalar>>;
};

template <class P, class Parts>
concept MapPolicy = std::default_initializable<typename P::Options> && Map < typename P::template Map<Parts>,
typename Parts::Sensors, typename Parts::Window,
    typename Parts::Landmarks > &&std::constructible_from<typename P::template Map<Parts>,
                                                          const typename Parts::Sensors&, const typename P::Options&>;

}  // namespace plumbline
