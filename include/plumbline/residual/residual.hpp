#pragma once
/// Concept of a residual: a type that holds one measurement, and returns value and analytic Jacobians in one call.
///
/// Semantics: r = prediction - measurement, not whitened; each J_r_<block> is the Jacobian by the increment of the
/// block (lie/plus.hpp); `valid` is false off the domain (e.g. a point behind the camera), and then no other member may
/// be read. A residual is independent of the solver: `linearize` takes the values of the blocks, the solver owns them.

#include <concepts>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// Members that every linearization has, besides its Jacobians.
template <class L>
concept Linearization = requires(const L& linearized) {
  { linearized.valid } -> std::convertible_to<bool>;
  { linearized.r.norm() } -> std::floating_point;
};

/// Members that every residual has.
template <class R>
concept Residual = std::floating_point<typename R::Scalar> && Linearization<typename R::Linearized> && requires {
  { R::dim } -> std::convertible_to<int>;
};

}  // namespace plumbline
