#pragma once
/// A pose between two poses, with its derivatives by both.                                  docs/math/lie.md
///
///   psi = Log(R0^T R1),  R(a) = R0 Exp(a psi),  p(a) = (1 - a) p0 + a p1,  0 <= a <= 1                       (12)
///   dphi(a) = [Exp(-a psi) - a Jr(a psi) Jl^-1(psi)] dphi0 + a Jr(a psi) Jr^-1(psi) dphi1
///   dp(a)   = R(a)^T [(1 - a) R0 dp0 + a R1 dp1]                                                             (13)
/// Valid for |psi| < pi - 0.1: beyond, the shorter way round is ambiguous.

#include <numbers>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <class S>
struct InterpolatedPose {
  bool valid;
  SE3<S> T;
  Mat<S, 6, 6> J_T_T0, J_T_T1;  ///< right increments (dphi, dp) of lie/plus.hpp
};

template <class S>
InterpolatedPose<S> interpolate(const SE3<S>& T0, const SE3<S>& T1, S a) {
  using Mat3 = Mat<S, 3, 3>;
  InterpolatedPose<S> out;
  const Vec<S, 3> psi = (T0.rotation().inverse() * T1.rotation()).log();
  out.valid = norm(psi) < std::numbers::pi_v<S> - S(0.1) && a >= 0 && a <= 1;
  if (!out.valid) return out;
  const SO3<S> step = SO3<S>::exp(a * psi);
  out.T = SE3<S>(T0.rotation() * step, (1 - a) * T0.p() + a * T1.p());  // (12)
  const Mat3 J = a * SO3<S>::right_jacobian(a * psi), Rt = out.T.R().transpose();
  const auto blocks = [](const Mat3& J_rotation, const Mat3& J_translation) {
    Mat<S, 6, 6> full = zeros<S, 6, 6>();
    full.template topLeftCorner<3, 3>() = J_rotation;
    full.template bottomRightCorner<3, 3>() = J_translation;
    return full;
  };
  out.J_T_T0 =
      blocks(step.matrix().transpose() - J * SO3<S>::left_jacobian_inverse(psi), (1 - a) * Rt * T0.R());  // (13)
  out.J_T_T1 = blocks(J * SO3<S>::right_jacobian_inverse(psi), a * Rt * T1.R());
  return out;
}

}  // namespace plumbline
