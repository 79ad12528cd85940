#pragma once
/// Relative pose of two cameras a (anchor) and j (target), and an anchored point in camera j, with Jacobians by both
/// poses.
///                                                                                          docs/math/point.md
/// A point with unit bearing f and inverse range lambda in camera a is in camera j, scaled by lambda,
///   P~ = A R_e f + lambda t,   A = R_cb R_j^T R_a,   t = A p_e + R_cb (R_j^T (p_a - p_j) - p_e)              (1)
/// with R_e, p_e = T_body_cam, R_cb = R_e^T; it is regular at lambda = 0. Jacobians by the increments:
///   dP~/d anchor  = [ -A [q]x , lambda A ],                q = R_e f + lambda p_e          3x6               (2)
///   dP~/d target  = R_cb [ [R_e P~ + lambda p_e]x , -lambda I ]                            3x6               (3)
///   dP~/d lambda  = t                                                                      3x1 [m]           (4)
/// Visual residuals depend on poses through T_j^-1 T_a alone: d/d anchor = -(d/d target) Ad(T_j^-1 T_a).           (4a)

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// An anchored point in camera j, scaled by lambda, with Jacobians by both poses.
template <class S>
struct ScaledPoint {
  Vec<S, 3> P;            ///< P~ = lambda P
  Mat<S, 3, 6> J_anchor;  ///< (2)
  Mat<S, 3, 6> J_target;  ///< (3)
};

/// Computed once for each pair of cameras and shared by all landmarks.
template <class S>
class RelativeView {
 public:
  RelativeView() = default;
  /// Poses of the body at anchor and target, and the extrinsics of the camera.
  RelativeView(const SE3<S>& T_world_anchor, const SE3<S>& T_world_target, const SE3<S>& T_body_cam)
      : R_e_(T_body_cam.R()), p_e_(T_body_cam.p()) {
    const Mat<S, 3, 3> R_a = T_world_anchor.R(), R_j = T_world_target.R(), R_ja = R_j.transpose() * R_a;
    A_.noalias() = R_e_.transpose() * R_ja;
    AR_e_.noalias() = A_ * R_e_;
    const Vec<S, 3> p = T_world_anchor.p() - T_world_target.p(), p_ja = R_j.transpose() * p, offset = p_ja - p_e_;
    t_.noalias() = A_ * p_e_;
    t_.noalias() += R_e_.transpose() * offset;
  }

  /// P~ of (1).
  Vec<S, 3> scaled_point(const Vec<S, 3>& bearing, S inverse_range) const {
    return AR_e_ * bearing + inverse_range * t_;
  }

  ScaledPoint<S> linearize(const Vec<S, 3>& bearing, S inverse_range) const {
    ScaledPoint<S> out;
    out.P = scaled_point(bearing, inverse_range);
    const Vec<S, 3> q = R_e_ * bearing + inverse_range * p_e_;
    const Mat<S, 3, 3> Aq = A_ * hat(q);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) {
        out.J_anchor(k, c) = -Aq(k, c);
        out.J_anchor(k, 3 + c) = inverse_range * A_(k, c);
      }
    }
    out.J_target = target_jacobian<3>(identity<S, 3>(), out.P, inverse_range);
    return out;
  }

  /// Jacobian by the target pose of a residual with the Jacobian J_r_P by P~, from (3).
  template <int Rows>
  Mat<S, Rows, 6> target_jacobian(const Mat<S, Rows, 3>& J_r_P, const Vec<S, 3>& P, S inverse_range) const {
    const Vec<S, 3> q = R_e_ * P + inverse_range * p_e_;
    const Mat<S, Rows, 3> B = product_transposed(J_r_P, R_e_);
    Mat<S, Rows, 6> out;
    set_block(out, 0, 0, product_hat(B, q));
    set_block(out, 0, 3, Mat<S, Rows, 3>(-inverse_range * B));
    return out;
  }

  /// Origin of the anchor camera in the target camera [m]; also (4).
  const Vec<S, 3>& t_target_anchor() const { return t_; }
  /// Rotation from the anchor camera to the target camera.
  const Mat<S, 3, 3>& R_target_anchor() const { return AR_e_; }
  /// Extrinsics of the camera.
  const Mat<S, 3, 3>& R_body_cam() const { return R_e_; }
  const Vec<S, 3>& p_body_cam() const { return p_e_; }

 private:
  Mat<S, 3, 3> R_e_, A_, AR_e_;
  Vec<S, 3> p_e_, t_;
};

}  // namespace plumbline
