#pragma once
/// All that ties landmarks of one kind to those of another: for each kind that holds others (`Kind::holds`), its terms
/// with the first kind before it that it holds. Nothing where no kind does.

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "plumbline/feature/collinear_terms.hpp"
#include "plumbline/feature/features.hpp"

namespace plumbline {

template <class Landmarks>
class LandmarkTies;

template <class... Stores>
class LandmarkTies<LandmarkSet<Stores...>> {
 public:
  static constexpr bool any = (false || ... || HoldsOthers<typename Stores::Kind>);

  /// Which ties take part, from where everything is now: before an optimization, and after it for the covariance.
  void choose(auto& landmarks, const auto& views) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.choose(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
  }
  /// After an optimization: lets go of what has not fitted for long.
  void finish(auto& landmarks, const auto& views) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.finish(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
  }

  /// Their cost, linearized for `eliminate`.
  double linearize(auto& landmarks, const auto& views) {
    double sum = 0;
    for_each([&](auto& ties, auto i, auto j) {
      sum += ties.linearize(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
    return sum;
  }
  double cost(auto& landmarks, const auto& views) {
    double sum = 0;
    for_each([&](auto& ties, auto i, auto j) {
      sum += ties.cost(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
    return sum;
  }

  /// Nothing but how they hold counts from here on.
  void forget_residuals() {
    for_each([&](auto& ties, auto, auto) { ties.forget_residuals(); });
  }

  /// After the landmarks' own terms have been eliminated.                                   solver.md (13)
  void eliminate(auto& landmarks, auto& terms, const auto& pairs, auto& normal) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.eliminate(landmarks.template get<i>(), std::get<i>(terms), landmarks.template get<j>(), std::get<j>(terms),
                     pairs, normal);
    });
  }
  /// The steps of the landmarks, corrected by those of what holds them; returns the predicted decrease.
  double solve(auto& terms, const auto& step, int stride) {
    double decrease = 0;
    for_each([&](auto& ties, auto i, auto j) {
      decrease += ties.solve(std::get<i>(terms), std::get<j>(terms), step, stride);
    });
    return decrease;
  }

 private:
  using All = std::tuple<Stores...>;
  template <std::size_t I>
  using KindOf = typename std::tuple_element_t<I, All>::Kind;

  template <std::size_t I, std::size_t J>
  static constexpr std::size_t held_by() {
    static_assert(J < I,
                  "plumbline: collinear features need points named before them, Features<Points<>, Collinear<>>");
    if constexpr (KindOf<I>::template holds<KindOf<J>>) {
      return J;
    } else {
      return held_by<I, J + 1>();
    }
  }

  /// visit(ties, index of the kind that holds, index of the kind that is held)
  void for_each(auto&& visit) {
    LandmarkSet<Stores...>::for_each_index([&]<std::size_t I>() {
      if constexpr (HoldsOthers<KindOf<I>>) {
        visit(std::get<I>(ties_), std::integral_constant<std::size_t, I>(),
              std::integral_constant<std::size_t, held_by<I, 0>()>());
      }
    });
  }

  template <std::size_t I>
  struct Nothing {};
  template <std::size_t I, bool holds = HoldsOthers<KindOf<I>>>
  struct TieOf {
    using Type = Nothing<I>;
  };
  template <std::size_t I>
  struct TieOf<I, true> {
    using Type = CollinearTerms<std::tuple_element_t<I, All>, std::tuple_element_t<held_by<I, 0>(), All>>;
  };
  template <std::size_t... I>
  static auto tuple_of(std::index_sequence<I...>) -> std::tuple<typename TieOf<I>::Type...>;

  [[no_unique_address]] decltype(tuple_of(std::index_sequence_for<Stores...>{})) ties_;
};

}  // namespace plumbline
