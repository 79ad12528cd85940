#pragma once
/// All constraints between landmarks of different kinds: for each kind with members, the terms with the first kind
/// before it that can be a member (`Kind::can_contain`). Empty where no kind has members.

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
  static constexpr bool any = (false || ... || HasMembers<typename Stores::Kind>);

  /// Chooses the active constraints at the current state: before an optimization, and after it for the covariance.
  void choose(auto& landmarks, const auto& views) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.choose(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
  }
  /// After an optimization: removes members that repeatedly do not fit.
  void finish(auto& landmarks, const auto& views) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.finish(landmarks.template get<i>(), landmarks.template get<j>(), views);
    });
  }

  /// Linearizes for `eliminate`; returns the cost.
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

  /// Sets the residuals to zero, keeping the Jacobians.
  void clear_residuals() {
    for_each([&](auto& ties, auto, auto) { ties.clear_residuals(); });
  }

  /// To be called after the landmarks were eliminated from their own rows.       docs/math/solver.md (13)
  void eliminate(auto& landmarks, auto& terms, const auto& pairs, auto& normal) {
    for_each([&](auto& ties, auto i, auto j) {
      ties.eliminate(landmarks.template get<i>(), std::get<i>(terms), landmarks.template get<j>(), std::get<j>(terms),
                     pairs, normal);
    });
  }
  /// Corrects the steps of members by those of their lines; returns the change of the predicted decrease.
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
  static constexpr std::size_t member_kind_of() {
    static_assert(J < I,
                  "plumbline: collinear features need points named before them, Features<Points<>, Collinear<>>");
    if constexpr (KindOf<I>::template can_contain<KindOf<J>>) {
      return J;
    } else {
      return member_kind_of<I, J + 1>();
    }
  }

  /// visit(ties, index of the kind with members, index of the kind of its members)
  void for_each(auto&& visit) {
    LandmarkSet<Stores...>::for_each_index([&]<std::size_t I>() {
      if constexpr (HasMembers<KindOf<I>>) {
        visit(std::get<I>(ties_), std::integral_constant<std::size_t, I>(),
              std::integral_constant<std::size_t, member_kind_of<I, 0>()>());
      }
    });
  }

  template <std::size_t I>
  struct Nothing {};
  template <std::size_t I, bool has_members = HasMembers<KindOf<I>>>
  struct TieOf {
    using Type = Nothing<I>;
  };
  template <std::size_t I>
  struct TieOf<I, true> {
    using Type = CollinearTerms<std::tuple_element_t<I, All>, std::tuple_element_t<member_kind_of<I, 0>(), All>>;
  };
  template <std::size_t... I>
  static auto tuple_of(std::index_sequence<I...>) -> std::tuple<typename TieOf<I>::Type...>;

  [[no_unique_address]] decltype(tuple_of(std::index_sequence_for<Stores...>{})) ties_;
};

}  // namespace plumbline
