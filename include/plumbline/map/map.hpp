#pragma once
/// Concept of a map: every call that an estimator makes. A map gets
///
///   on_keyframe(AdoptedKeyframe)   a frame has become a keyframe; its image is here, its pose is still the window's
///   on_retired(Retired)            a keyframe leaves the window with its last estimate, in any order of sequence
///   on_world_change(WorldChange)   the world frame or the unit of length changes, or what was learned is wrong
///
/// For one world the order is: on_keyframe of each frame before its on_retired; `transformed` at most once, after which
/// states are metric; `rejected` or `reset` last. A map policy names a map for the parts of an estimator:
///   template <class Parts> using Map = ...;   constructed by Map(options) with the options of the estimator

#include <concepts>

#include "plumbline/lie/se3.hpp"
#include "plumbline/map/adopted_keyframe.hpp"
#include "plumbline/map/retired.hpp"
#include "plumbline/map/world_change.hpp"

namespace plumbline {

template <class M, class Sensors, class State, class Landmarks>
concept Map = requires(M& map, const M& known, const AdoptedKeyframe<State, Sensors, Landmarks>& keyframe,
                       const Retired<State, Landmarks>& retired, const WorldChange<typename Sensors::Scalar>& change) {
  map.on_keyframe(keyframe);
  map.on_retired(retired);
  map.on_world_change(change);
  { known.T_map_world() } -> std::convertible_to<SE3<typename Sensors::Scalar>>;  // drift of the world, corrected
};

}  // namespace plumbline
