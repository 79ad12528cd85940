#pragma once
/// The concept of a matrix Lie group as plumbline uses it.
///
/// Semantics: `exp` maps a tangent vector (dof x 1, rotation first) to the group, `log` is its inverse on the principal
/// branch, `*` composes, `inverse` inverts, `adjoint` satisfies  X exp(d) X^-1 = exp(adjoint(X) d).

#include <concepts>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <class G>
concept HasTangent = std::floating_point<typename G::Scalar> && requires {
  { G::dof } -> std::convertible_to<int>;
  typename G::Tangent;
};

template <class G>
concept HasExpLog = requires(const G& x, const typename G::Tangent& d) {
  { G::exp(d) } -> std::same_as<G>;
  { x.log() } -> std::same_as<typename G::Tangent>;
};

template <class G>
concept Composes = requires(const G& x) {
  { x* x } -> std::same_as<G>;
  { x.inverse() } -> std::same_as<G>;
};

template <class G>
concept LieGroup = HasTangent<G> && HasExpLog<G> && Composes<G> && requires(const G& x) {
  { x.adjoint() } -> std::same_as<Mat<typename G::Scalar, G::dof, G::dof>>;
};

}  // namespace plumbline
