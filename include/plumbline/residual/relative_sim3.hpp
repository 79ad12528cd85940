#pragma once
/// Measured similarity of frame j to frame i, against those of both to the world: monocular, the scale drifts too.
///                                                                                       docs/math/pose_graph.md
///   r     = minus(S_ij, S~) = [Log R_E; t_E; ln s_E],  E = S~^-1 S_ij,  S_ij = S_i^-1 S_j        7x1          (9)
///   J_r_j = blkdiag(Jr^-1(Log R_E), s_E R_E, 1)                                                  7x7          (10)
///   J_r_i = [-Jr^-1(Log R_E) R_ij^T, 0, 0;  R~^T [t_ij]x / s~, -R~^T / s~, -R~^T t_ij / s~;  0, 0, -1]        (11)
/// by the right increments [dphi, dt, dsig] of S_i and S_j. r is a right increment of the measurement S~.
///
///   d_ik = Ad(S_jk^-1) d_ij + d_jk                                                                            (12)

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct RelativeSim3Residual {
  using Scalar = S;
  using Pose = Sim3<S>;
  static constexpr int dim = 7;
  struct Linearized {
    bool valid;
    Vec<S, 7> r;
    Mat<S, 7, 7> J_r_i, J_r_j;
  };

  Pose measured;  ///< S~ of S_i_j

  Vec<S, 7> residual(const Pose& S_world_i, const Pose& S_world_j) const {
    return minus(S_world_i.inverse() * S_world_j, measured);
  }

  Linearized linearize(const Pose& S_world_i, const Pose& S_world_j) const {
    const Pose S_i_j = S_world_i.inverse() * S_world_j;
    const Mat<S, 3, 3> R_ji = S_i_j.rotation().inverse().matrix();
    const Mat<S, 3, 3> Rt = measured.rotation().inverse().matrix() / measured.scale();
    Linearized out;
    out.r = minus(S_i_j, measured);               // (9)
    out.J_r_j = minus_jacobian(S_i_j, measured);  // (10)
    set_zero(out.J_r_i);                          // (11)
    set_block(out.J_r_i, 0, 0, Mat<S, 3, 3>(-product(block<3, 3>(out.J_r_j, 0, 0), R_ji)));
    set_block(out.J_r_i, 3, 0, product_hat(Rt, S_i_j.t()));
    set_block(out.J_r_i, 3, 3, Mat<S, 3, 3>(-Rt));
    set_block(out.J_r_i, 3, 6, Vec<S, 3>(-times(Rt, S_i_j.t())));
    out.J_r_i(6, 6) = S(-1);
    out.valid = all_finite(out.r) && all_finite(out.J_r_i);
    return out;
  }

  static Pose moved(const Pose& X, const Vec<S, 7>& d) { return plus(X, d); }
  /// The matrix of (12), which takes a right increment of S_i_j to one of S_i_k; i is any frame.
  static Mat<S, 7, 7> transport(const Pose& S_i_j, const Pose& S_i_k) { return (S_i_k.inverse() * S_i_j).adjoint(); }
};

static_assert(Residual<RelativeSim3Residual<float>> && Residual<RelativeSim3Residual<double>>);

}  // namespace plumbline
