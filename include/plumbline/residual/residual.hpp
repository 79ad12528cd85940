#pragma once
/// Residuals are data: a type holds one measurement, and one call returns its value and its analytic Jacobians.
///
/// Semantics: r = prediction - measurement, not whitened; each J_r_<block> is the derivative with respect to the
/// block's increment under lie/plus.hpp; `valid` is false off the domain (point behind the camera), and then nothing
/// else may be read. A residual never learns who solves it: `linearize` takes the blocks' values, the solver owns the
/// blocks.

#include <concepts>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// What every linearization has in common, whichever blocks it has Jacobians for.
template <class L>
concept Linearization = requires(const L& linearized) {
  { linearized.valid } -> std::convertible_to<bool>;
  { linearized.r.norm() } -> std::floating_point;
};

template <class R>
concept Residual = std::floating_point<typename R::Scalar> && Linearization<typename R::Linearized> && requires {
  { R::dim } -> std::convertible_to<int>;
};

}  // namespace plumbline
