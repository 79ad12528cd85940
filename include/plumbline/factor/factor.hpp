#pragma once
/// Concept of a factor: a measurement of the state of one frame that is no landmark's, e.g. an absolute position.
///                                                                                            docs/math/factors.md
///   |r(x)|^2 / 2   is its term of the cost, r whitened: L (prediction - measurement), L^T L the information
///
/// A type F has
///   Scalar, dim        the scalar, the number of rows
///   Blocks             the blocks of the frame that r depends on, a Layout: Layout<state::Pose, state::Velocity>
///   is_marginalized    when the frame is retired its rows enter the prior (true) or are removed (false)
///   linearize(x, x0)   {valid, r, J_r_x}: r at x, J_r_x at the first estimate x0, by the increments of the blocks in
///                      the order of Blocks (lie/plus.hpp). Not valid off the domain; then r and J_r_x may not be read
///   residual(x)        r alone
/// x and x0 are values of a frame by name: x.T_world_body, and with an IMU x.v_world_body, x.bias_gyro, x.bias_accel.
///
/// A factor is data: it owns no state, and does not depend on the solver.

#include <concepts>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

namespace detail {
template <class T, class Value>
concept IsValue = std::same_as<std::remove_cvref_t<T>, Value>;
}  // namespace detail

/// What a factor is, before any value.
template <class F>
concept FactorShape = std::floating_point<typename F::Scalar> && requires {
  { F::dim } -> std::convertible_to<int>;
  { F::Blocks::dim } -> std::convertible_to<int>;
  { F::is_marginalized } -> std::convertible_to<bool>;
};

/// What `linearize` returns.
template <class L, class F>
concept FactorLinearization = requires(const L& linearized) {
  { linearized.valid } -> std::convertible_to<bool>;
  { linearized.r } -> detail::IsValue<Vec<typename F::Scalar, F::dim>>;
  { linearized.J_r_x } -> detail::IsValue<Mat<typename F::Scalar, F::dim, F::Blocks::dim>>;
};

template <class F>
concept Factor = FactorShape<F> && requires(const F& factor, const NavState<typename F::Scalar>& x) {
  { factor.linearize(x, x) } -> FactorLinearization<F>;
  { factor.residual(x) } -> detail::IsValue<Vec<typename F::Scalar, F::dim>>;
};

namespace detail {
template <class FrameLayout, class S, int Rows, class... Blocks>
Mat<S, Rows, FrameLayout::dim> spread(const Mat<S, Rows, Layout<Blocks...>::dim>& J, Layout<Blocks...>) {
  Mat<S, Rows, FrameLayout::dim> out = zeros<S, Rows, FrameLayout::dim>();
  (set_block(out, 0, FrameLayout::template offset<Blocks>,
             block<Rows, Blocks::dim>(J, 0, Layout<Blocks...>::template offset<Blocks>)),
   ...);
  return out;
}
}  // namespace detail

/// J_r_x of a factor, with a column for each parameter of a frame of layout FrameLayout.
template <class FrameLayout, Factor F>
Mat<typename F::Scalar, F::dim, FrameLayout::dim> by_frame(
    const Mat<typename F::Scalar, F::dim, F::Blocks::dim>& J_r_x) {
  return detail::spread<FrameLayout, typename F::Scalar, F::dim>(J_r_x, typename F::Blocks());
}

}  // namespace plumbline
