#pragma once
/// The feature kinds of an estimator as one type, e.g. Features<Points<180>, Lines<60>>: capacities are part of it.
///
/// A kind names, for a rig and a number of keyframe slots, the map that keeps its landmarks (`Map<Sensors, Slots>`).

#include <cstddef>
#include <tuple>
#include <utility>

#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The maps of all kinds, visited in order.
template <class... Maps>
class FeatureMaps {
 public:
  using Options = std::tuple<typename Maps::Options...>;
  /// Whether a kind tells which bearings of two views belong together: a camera without depth starts by them.
  static constexpr bool relates_two_views = (requires { Maps::relates_two_views; } || ...);

  explicit FeatureMaps(const Options& options) : FeatureMaps(options, std::index_sequence_for<Maps...>()) {}

  void for_each(auto&& visit) {
    std::apply([&](Maps&... map) { (visit(map), ...); }, maps_);
  }
  void for_each(auto&& visit) const {
    std::apply([&](const Maps&... map) { (visit(map), ...); }, maps_);
  }
  /// The sum of visit(map) over all kinds.
  auto sum(auto&& visit) const {
    return std::apply([&](const Maps&... map) { return (visit(map) + ...); }, maps_);
  }

  template <class Map>
  const Map& get() const {
    return std::get<Map>(maps_);
  }

  /// A tuple of one X<Map> for each kind.
  template <template <class> class X>
  using TupleOf = std::tuple<X<Maps>...>;

 private:
  /// Each map is built where it stays: one may be larger than a stack.
  template <std::size_t... I>
  FeatureMaps(const Options& options, std::index_sequence<I...>) : maps_(std::get<I>(options)...) {}

  std::tuple<Maps...> maps_;
};

template <class... Kinds>
struct Features {
  static_assert(sizeof...(Kinds) > 0, "plumbline: an estimator needs a feature kind, e.g. Features<Points<180>>");

  template <SensorRig Sensors, int Slots>
  using Maps = FeatureMaps<typename Kinds::template Map<Sensors, Slots>...>;
};

}  // namespace plumbline
