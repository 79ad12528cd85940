#pragma once
/// All that ties landmarks of one kind to those of another: for each kind that holds others (`Kind::holds`), its terms
/// with the first kind before it that it holds. Nothing where no kind does.

#include <cstddef>
#include <tuple>
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

  /// visit(ties, holders, held, terms of the holders, terms of the held)
  void for_each(auto& landmarks, auto& terms, auto&& visit) {
    LandmarkSet<Stores...>::for_each_index([&]<std::size_t I>() {
      if constexpr (HoldsOthers<KindOf<I>>) {
        constexpr std::size_t J = held_by<I, 0>();
        visit(std::get<I>(ties_), landmarks.template get<I>(), landmarks.template get<J>(), std::get<I>(terms),
              std::get<J>(terms));
      }
    });
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
