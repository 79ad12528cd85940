#pragma once
/// An edge of a pose graph: a measured relative pose with its information.                 docs/math/pose_graph.md (13)
///
///   L r,  L J_r_i,  L J_r_j  of two nodes,  L^T L = covariance^-1
///   composed: T_ik = T_ij T_jk,  P_ik = A P_ij A^T + P_jk,  A = transport(T_j, T_k)                          (20)
///   inverse:  T_ji = T_ij^-1,    P_ji = A P_ij A^T,         A = transport(T_j, T_i)                          (24)
/// The covariance is that of a right increment of the measured pose.

#include <cmath>
#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_pose_yaw.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

/// A measured pose of one node in another.
///   linearize(T_i, T_j)   value and Jacobians by the increments of both nodes; residual(T_i, T_j) the value alone
///   moved(T, d)           a node moved by its increment
///   transport(T_j, T_k)   takes the error of T_i_j to that of T_i_k
template <class R>
concept RelativeResidual = Residual<R> &&
    requires(const R& residual, const typename R::Pose& T, const Vec<typename R::Scalar, R::dim>& d) {
  { residual.measured } -> std::convertible_to<typename R::Pose>;
  { residual.residual(T, T) } -> std::same_as<Vec<typename R::Scalar, R::dim>>;
  { residual.linearize(T, T) } -> std::same_as<typename R::Linearized>;
  { R::moved(T, d) } -> std::same_as<typename R::Pose>;
  { R::transport(T, T) } -> std::same_as<Mat<typename R::Scalar, R::dim, R::dim>>;
};

template <RelativeResidual Residual>
struct PoseGraphEdge {
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  static constexpr int dim = Residual::dim;
  using Covariance = Mat<S, dim, dim>;

  /// Whitened, for normal equations in A. Of an invalid linearization r is NaN, and the rest zero.
  template <class A>
  struct Rows {
    Vec<A, dim> r;
    Mat<A, dim, dim> J_i, J_j;
  };

  Residual residual;
  Covariance L;  ///< lower triangular

  /// Fails where a number is not finite, or the covariance has no inverse.
  static Result<PoseGraphEdge> make(const Pose& measured, const Covariance& covariance) {
    if (!measured.is_finite() || !all_finite(covariance)) return Error::not_finite;
    const Result<Covariance> L = square_root_information(covariance);
    if (!L || !all_finite(*L)) return Error::not_positive_definite;
    return PoseGraphEdge{{measured}, *L};
  }

  template <class A>
  Rows<A> linearize(const Pose& T_i, const Pose& T_j) const {
    const typename Residual::Linearized lin = residual.linearize(T_i, T_j);
    Rows<A> out{zeros<A, dim>(), zeros<A, dim, dim>(), zeros<A, dim, dim>()};
    out.r[0] = A(NAN);
    if (!lin.valid) return out;
    return {cast_to<A>(times(L, lin.r)), cast_to<A>(product(L, lin.J_r_i)), cast_to<A>(product(L, lin.J_r_j))};
  }
  /// |L r|^2, of `dim` degrees of freedom.
  template <class A>
  A chi2(const Pose& T_i, const Pose& T_j) const {
    return squared_norm(cast_to<A>(times(L, residual.residual(T_i, T_j))));
  }
  /// The covariance as it was given.
  Covariance covariance() const {
    Covariance inverse = zeros<Covariance>();
    for (int c = 0; c < dim; ++c) {
      inverse(c, c) = S(1) / L(c, c);
      for (int r = c + 1; r < dim; ++r) {
        S sum = S(0);
        for (int k = c; k < r; ++k) sum += L(r, k) * inverse(k, c);
        inverse(r, c) = -sum / L(r, r);
      }
    }
    return product_transposed(inverse, inverse);
  }

  /// (20): this edge from i to j and then another one from j to k, as one with the covariance of both.
  Result<PoseGraphEdge> composed(const Pose& T_map_i, const PoseGraphEdge& T_j_k) const {
    const Pose T_map_j = T_map_i * residual.measured, T_map_k = T_map_j * T_j_k.residual.measured;
    Covariance P = transported(T_map_j, T_map_k);
    const Covariance Q = T_j_k.covariance();
    for (int k = 0; k < dim * dim; ++k) P.data()[k] += Q.data()[k];
    return make(residual.measured * T_j_k.residual.measured, P);
  }
  /// (24): the edge from j to i.
  Result<PoseGraphEdge> inverse(const Pose& T_map_i) const {
    return make(residual.measured.inverse(), transported(T_map_i * residual.measured, T_map_i));
  }

 private:
  Covariance transported(const Pose& T_map_from, const Pose& T_map_to) const {
    const Covariance A = Residual::transport(T_map_from, T_map_to);
    return product_transposed(product(A, covariance()), A);
  }
};

static_assert(RelativeResidual<RelativePoseResidual<float>> && RelativeResidual<RelativePoseYawResidual<float>>);
static_assert(RelativeResidual<RelativeSim3Residual<double>> && !RelativeResidual<SE3<float>>);

}  // namespace plumbline
