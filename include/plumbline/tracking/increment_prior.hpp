#pragma once
/// Prior of the motion of the body between two frames, before their images are aligned.            docs/math/direct.md
///
///   T = T_cur_prev maps the previous body's coordinates into the current one's
///   r_R = Log(R~^T R),   dr_R/d dphi = Jr^-1(r_R)                                                             (4)
///   r_p = p - p~,        dr_p/d dp   = R                                                                      (5)
///   Sigma_R = R~^T S_phi R~,   Sigma_p = S_p + [p~]x S_phi [p~]x^T                                            (6)
/// S_phi, S_p: covariance of rotation and position of the current body, as predicted, in its own coordinates.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
struct IncrementPrior {
  struct Linearized {
    Vec<S, 6> r;     ///< whitened [rotation, position]
    Mat<S, 6, 6> J;  ///< by [dphi, dp] of T
  };

  bool valid = false;                                                         ///< false: no prior
  SE3<S> T_cur_prev;                                                          ///< (R~, p~)
  Mat<S, 3, 3> L_rotation = zeros<S, 3, 3>(), L_position = zeros<S, 3, 3>();  ///< L^T L = Sigma^-1

  /// Of a current body predicted at `T_cur_prev` from the previous one, its pose's error [dphi, dp] known up to
  /// `sigma`.
  static IncrementPrior of(const SE3<S>& T_cur_prev, const Vec<S, 6>& sigma) {
    IncrementPrior out;
    out.T_cur_prev = T_cur_prev;
    Mat<S, 3, 3> S_phi = zeros<S, 3, 3>(), Sigma_p = zeros<S, 3, 3>();
    for (int k = 0; k < 3; ++k) {
      S_phi(k, k) = sigma[k] * sigma[k];
      Sigma_p(k, k) = sigma[3 + k] * sigma[3 + k];
    }
    const Mat<S, 3, 3> R = T_cur_prev.R(), P = hat(T_cur_prev.p());
    const Mat<S, 3, 3> Rt = R.transpose(), RtS = product(Rt, S_phi), PS = product(P, S_phi);
    Sigma_p += product_transposed(PS, P);  // (6)
    const auto L_R = square_root_information(product_transposed(RtS, Rt)), L_p = square_root_information(Sigma_p);
    out.valid = bool(L_R) && bool(L_p);
    if (!out.valid) return out;
    out.L_rotation = *L_R;
    out.L_position = *L_p;
    return out;
  }

  Linearized linearize(const SE3<S>& T) const {
    Linearized out;
    const Vec<S, 3> r_R = (T_cur_prev.rotation().inverse() * T.rotation()).log(), r_p = T.p() - T_cur_prev.p();
    set_segment(out.r, 0, product(L_rotation, r_R));
    set_segment(out.r, 3, product(L_position, r_p));
    set_zero(out.J);
    set_block(out.J, 0, 0, product(L_rotation, SO3<S>::right_jacobian_inverse(r_R)));  // (4)
    set_block(out.J, 3, 3, product(L_position, T.R()));                                // (5)
    return out;
  }
};

}  // namespace plumbline
