#pragma once
/// List of the feature kinds of an estimator as one type, e.g. Features<Points<180>, Lines<60>>, with their capacities.
///
/// An entry names its kind for a rig (`template <class Sensors> using Kind`), the capacity of its store, and the name
/// of its options (`Named`). The order matters: a kind may read the landmarks of those before it.

#include <cstddef>
#include <tuple>
#include <utility>

#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The stores of all kinds, visited in order.
template <class... Stores>
class LandmarkSet {
 public:
  static constexpr std::size_t kinds = sizeof...(Stores);

  explicit LandmarkSet(const auto&... options) : stores_(options...) {}

  void for_each(auto&& visit) {
    std::apply([&](Stores&... store) { (visit(store), ...); }, stores_);
  }
  void for_each(auto&& visit) const {
    std::apply([&](const Stores&... store) { (visit(store), ...); }, stores_);
  }
  /// visit(store, element) with the element of a TupleOf for that kind.
  void for_each_with(auto& tuple, auto&& visit) {
    for_each_index([&]<std::size_t I>() { visit(std::get<I>(stores_), std::get<I>(tuple)); });
  }
  void for_each_with(auto& tuple, auto&& visit) const {
    for_each_index([&]<std::size_t I>() { visit(std::get<I>(stores_), std::get<I>(tuple)); });
  }
  /// Visits the kinds whose landmarks are no sets of members.
  void for_each_independent(auto&& visit) const {
    for_each([&]<class Store>(const Store& store) {
      if constexpr (!HasMembers<typename Store::Kind>) visit(store);
    });
  }

  static constexpr double no_limit_px = 1e9;  ///< numerics: larger than any image

  /// Mean motion of the landmarks in view since the frame in `slot`, without those that moved by `below` or more [px];
  /// 0 without landmarks.
  double motion_since(int slot, double below = no_limit_px) const {
    double sum_px = 0;
    int count = 0;
    for_each_independent([&](const auto& store) { store.add_motion_since(slot, below, sum_px, count); });
    return count > 0 ? sum_px / count : 0;
  }
  /// Number of landmarks observed by the latest frame (seen), and of the located ones among them (tracked).
  int seen_count() const {
    int n = 0;
    for_each_independent([&](const auto& store) { n += store.seen_count(); });
    return n;
  }
  int tracked_count() const {
    int n = 0;
    for_each_independent([&](const auto& store) { n += store.tracked_count(); });
    return n;
  }
  /// Harmonic mean of the ranges of the tracked landmarks [m]; 1 without landmarks.
  template <class S>
  S mean_depth() const {
    S inverse_sum = S(0);
    int count = 0;
    for_each_independent([&](const auto& store) { store.add_inverse_ranges(inverse_sum, count); });
    return count > 0 ? S(count) / inverse_sum : S(1);
  }

  /// The stores before the I-th, as constant references.
  template <std::size_t I>
  auto before() const {
    return [&]<std::size_t... J>(std::index_sequence<J...>) { return std::tie(std::get<J>(stores_)...); }
    (std::make_index_sequence<I>{});
  }

  template <std::size_t I>
  auto& get() {
    return std::get<I>(stores_);
  }
  template <std::size_t I>
  const auto& get() const {
    return std::get<I>(stores_);
  }

  /// A tuple of one X<Store> for each kind.
  template <template <class> class X>
  using TupleOf = std::tuple<X<Stores>...>;

  static void for_each_index(auto&& visit) {
    [&]<std::size_t... I>(std::index_sequence<I...>) { (visit.template operator()<I>(), ...); }
    (std::make_index_sequence<kinds>{});
  }

 private:
  std::tuple<Stores...> stores_;
};

template <class... Entries>
struct Features {
  static_assert(sizeof...(Entries) > 0, "plumbline: an estimator needs a feature kind, e.g. Features<Points<180>>");

  template <class Entry, SensorRig Sensors, int Slots>
  using StoreOf = LandmarkStore<typename Entry::template Kind<Sensors>, Entry::capacity, Slots>;

  template <SensorRig Sensors, int Slots>
  using Landmarks = LandmarkSet<StoreOf<Entries, Sensors, Slots>...>;
};

}  // namespace plumbline
