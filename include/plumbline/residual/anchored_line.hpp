#pragma once
/// Residual of a line anchored in one camera and measured, by its endpoints or their depth, in another one.
///                                                                                          docs/math/line.md
///
///   (n_j, v_j) = (R n_a + t x R v_a, R v_a),   (R, t) = T_cam_j_cam_a,  (n_a, v_a) of the landmark            (13)
///   J_r_target = (12) in camera j                                                                   2x6
///   J_r_anchor = -(12) in camera a with H_n = J_r_n R, H_v = (J_r_n [t]x + J_r_v) R                 2x6       (14)
///   J_r_line   = [H_n, H_v] d(n_a; v_a)/d theta                                                     2x4       (15)
/// Only the relative pose enters, which avoids the cancellation of large moments in world coordinates.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

/// The line of the anchor camera in the target camera.                                                          (13)
template <class S>
Plucker<S> line_in_target(const RelativeView<S>& view, const Plucker<S>& line_anchor) {
  const Vec<S, 3> v = view.R_target_anchor() * line_anchor.v;
  return {view.R_target_anchor() * line_anchor.n + view.t_target_anchor().cross(v), v};
}

/// A line in its anchor camera with its Jacobian, shared by all of its residuals.
template <class S>
struct LinearizedLine {
  Plucker<S> plucker;
  Mat<S, 6, 4> J;  ///< d(n; v)/d theta
  explicit LinearizedLine(const Line3<S>& line) : plucker(line.plucker()), J(line.plucker_jacobian()) {}
};

/// [H_n, H_v] of (14): converts derivatives by the line in the target camera to those by the line in the anchor camera.
template <class S, int Rows>
CameraLineLinearization<S, Rows> by_line_in_anchor(const CameraLineLinearization<S, Rows>& lin,
                                                   const RelativeView<S>& view) {
  Mat<S, Rows, 3> tilted = product_hat(lin.J_r_n, view.t_target_anchor());
  tilted += lin.J_r_v;
  return {lin.valid, lin.r, product(lin.J_r_n, view.R_target_anchor()), product(tilted, view.R_target_anchor())};
}

/// J_r_line, (15).
template <class S, int Rows>
Mat<S, Rows, 4> by_landmark(const CameraLineLinearization<S, Rows>& in_anchor, const LinearizedLine<S>& line) {
  Mat<S, Rows, 4> J = product(in_anchor.J_r_n, block<3, 4>(line.J, 0, 0));
  J += product(in_anchor.J_r_v, block<3, 4>(line.J, 3, 0));
  return J;
}

/// `Measurement`: LineReprojection or LineInverseDepth.
template <class Measurement>
struct AnchoredLine {
  using Scalar = typename Measurement::Scalar;
  using S = Scalar;
  static constexpr int dim = Measurement::dim;
  using Linearized = AnchoredLinearization<S, dim, 4>;
  /// A residual in the anchor itself does not depend on poses.
  struct AnchorLinearized {
    bool valid;
    Vec<S, dim> r;
    Mat<S, dim, 4> J_r_line;
  };
  Measurement measurement;

  /// `line` in the anchor camera, measured by the target camera.
  Linearized linearize(const RelativeView<S>& view, const Line3<S>& line) const {
    const LinearizedLine<S> linearized(line);
    const Plucker<S> in_target = line_in_target(view, linearized.plucker);
    const CameraLineLinearization<S, dim> lin = measurement.linearize(in_target);
    Linearized out;
    out.valid = lin.valid;
    if (!out.valid) return out;
    const CameraLineLinearization<S, dim> in_anchor = by_line_in_anchor(lin, view);
    const Mat<S, 3, 3> R_cam_body = view.R_body_cam().transpose();
    out.r = lin.r;
    out.J_r_anchor = -line_pose_jacobian(in_anchor, linearized.plucker, R_cam_body, view.p_body_cam());  // (14)
    out.J_r_target = line_pose_jacobian(lin, in_target, R_cam_body, view.p_body_cam());
    out.J_r_lambda = by_landmark(in_anchor, linearized);
    return out;
  }

  /// For a measurement by the anchor camera.
  AnchorLinearized linearize_in_anchor(const LinearizedLine<S>& line) const {
    const CameraLineLinearization<S, dim> lin = measurement.linearize(line.plucker);
    AnchorLinearized out;
    out.valid = lin.valid;
    if (!out.valid) return out;
    out.r = lin.r;
    out.J_r_line = by_landmark(lin, line);
    return out;
  }
  AnchorLinearized linearize_in_anchor(const Line3<S>& line) const {
    return linearize_in_anchor(LinearizedLine<S>(line));
  }
};

template <std::floating_point S>
using AnchoredLineReprojection = AnchoredLine<LineReprojection<S>>;
template <std::floating_point S>
using AnchoredLineInverseDepth = AnchoredLine<LineInverseDepth<S>>;

static_assert(Residual<AnchoredLineReprojection<float>> && Residual<AnchoredLineInverseDepth<double>>);

}  // namespace plumbline
