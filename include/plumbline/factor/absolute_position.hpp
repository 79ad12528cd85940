#pragma once
/// Factor: position of a point of the body measured in the world, e.g. of a GNSS antenna or a tracked marker.
///                                                                                            docs/math/factors.md
///   r      = L (p_world_body + R_world_body p_body_antenna - p_measured)      3x1                             (2)
///   J_r_x  = L [-R_world_body [p_body_antenna]x,  R_world_body]               3x6, (dphi, dp) of T_world_body (3)
/// p_measured is in the frame `world` of the estimator: the transform from the frame of the receiver is the caller's.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/factor/factor.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

/// (The concept of S is a static_assert: backend policies take templates of a plain type.)
template <class S>
struct AbsolutePosition {
  static_assert(std::floating_point<S>);
  using Scalar = S;
  using Blocks = Layout<state::Pose>;
  static constexpr int dim = 3;
  static constexpr bool is_marginalized = true;
  struct Linearized {
    bool valid;
    Vec<S, 3> r;
    Mat<S, 3, 6> J_r_x;
  };

  Vec<S, 3> p_measured;                      ///< the antenna in the world [m]
  Mat<S, 3, 3> L;                            ///< square root of the information, L^T L = covariance^-1 [1/m]
  Vec<S, 3> p_body_antenna = zeros<S, 3>();  ///< lever arm [m]

  /// With the covariance of the measurement in the world [m^2]; fails when that is not positive definite.
  static Result<AbsolutePosition> from_covariance(const Vec<S, 3>& p_measured, const Mat<S, 3, 3>& covariance,
                                                  const Vec<S, 3>& p_body_antenna = zeros<S, 3>()) {
    const auto L = square_root_information(covariance);
    if (!L) return L.error();
    return AbsolutePosition{p_measured, *L, p_body_antenna};
  }

  /// r at x, the Jacobian at the first estimate x0.
  Linearized linearize(const auto& x, const auto& x0) const {
    Linearized out;
    out.r = residual(x);  // (2)
    const Mat<S, 3, 3> L_R = product(L, x0.T_world_body.R());
    set_block(out.J_r_x, 0, 0, product_hat(L_R, Vec<S, 3>(-p_body_antenna)));  // (3)
    set_block(out.J_r_x, 0, 3, L_R);
    out.valid = all_finite(out.r) && all_finite(out.J_r_x);
    return out;
  }
  Vec<S, 3> residual(const auto& x) const {
    return times(L, Vec<S, 3>(x.T_world_body * p_body_antenna - p_measured));  // (2)
  }
};

static_assert(Factor<AbsolutePosition<float>> && Factor<AbsolutePosition<double>>);

}  // namespace plumbline
