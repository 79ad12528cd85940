#pragma once
/// The one retraction of the library: right, rotation first.                                docs/conventions.md
///
///   plus(T, [dphi; dp])  = (R Exp(dphi), p + R dp)                                                           (1)
///   minus(T1, T0)        = [Log(R0^T R1); R0^T (p1 - p0)],  plus(T0, minus(T1, T0)) = T1                     (2)
///   d minus(T, T0) / dT  = blkdiag(Jr^-1(Log(R0^T R)), R0^T R)                                               (3)
///   plus((s, R, t), [dphi; dt; dsig]) = (s e^dsig, R Exp(dphi), t + s R dt),  minus(S1, S0) = [Log R_E; t_E; ln s_E],
///   E = S0^-1 S1;  d minus(S, S0) / dS = blkdiag(Jr^-1(Log R_E), s_E R_E, 1)                                  (4)
/// Vectors are additive.

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <class S>
SO3<S> plus(const SO3<S>& R, const Vec<S, 3>& dphi) {
  return R * SO3<S>::exp(dphi);
}

template <class S>
SE3<S> plus(const SE3<S>& T, const Vec<S, 6>& d) {
  return SE3<S>(plus(T.rotation(), segment<3>(d, 0)), T.p() + T.rotation() * segment<3>(d, 3));
}

template <class S>
Sim3<S> plus(const Sim3<S>& X, const Vec<S, 7>& d) {
  return X * Sim3<S>(elementary::exp(d[6]), SO3<S>::exp(segment<3>(d, 0)), segment<3>(d, 3));
}

template <class S, int N>
Vec<S, N> plus(const Vec<S, N>& x, const Vec<S, N>& d) {
  return x + d;
}

template <class S>
Vec<S, 3> minus(const SO3<S>& R1, const SO3<S>& R0) {
  return (R0.inverse() * R1).log();
}

template <class S>
Vec<S, 6> minus(const SE3<S>& T1, const SE3<S>& T0) {
  Vec<S, 6> d;
  set_segment(d, 0, minus(T1.rotation(), T0.rotation()));
  set_segment(d, 3, T0.rotation().inverse() * Vec<S, 3>(T1.p() - T0.p()));
  return d;
}

template <class S>
Vec<S, 7> minus(const Sim3<S>& X1, const Sim3<S>& X0) {
  const Sim3<S> E = X0.inverse() * X1;
  Vec<S, 7> d;
  d << E.rotation().log(), E.t(), elementary::log(E.scale());
  return d;
}

/// d minus(R, R0) / dR, 3x3.
template <class S>
Mat<S, 3, 3> minus_jacobian(const SO3<S>& R, const SO3<S>& R0) {
  return SO3<S>::right_jacobian_inverse(minus(R, R0));
}

/// (4), 7x7.
template <class S>
Mat<S, 7, 7> minus_jacobian(const Sim3<S>& X, const Sim3<S>& X0) {
  const Sim3<S> E = X0.inverse() * X;
  Mat<S, 7, 7> J = identity<S, 7>();
  set_block(J, 0, 0, SO3<S>::right_jacobian_inverse(E.rotation().log()));
  J.template block<3, 3>(3, 3) = E.scale() * E.rotation().matrix();
  return J;
}

/// (3), 6x6.
template <class S>
Mat<S, 6, 6> minus_jacobian(const SE3<S>& T, const SE3<S>& T0) {
  const SO3<S> R0_R = T0.rotation().inverse() * T.rotation();
  Mat<S, 6, 6> J = zeros<S, 6, 6>();
  set_block(J, 0, 0, SO3<S>::right_jacobian_inverse(R0_R.log()));
  set_block(J, 3, 3, R0_R.matrix());
  return J;
}

}  // namespace plumbline
