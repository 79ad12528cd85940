#pragma once
/// Residual of a point on a line, each anchored in a camera of its own.                     docs/math/collinear.md
///
///   P~ = R f + lambda t, (R, t) = T_line_point   the point in the line's camera, scaled by lambda (relative_view.hpp)
///   r = [ u1 . P~ ; u3 . P~ + lambda d ],  d = w1/w2,   |r| = lambda * distance          2x1 [rad]            (1)
///   J_r_P      = N = [u1^T; u3^T]                                                        2x3
///   J_r_lambda = N t + [0; d]                                                            2x1
///   J_r_line   = [ 0, -u3.P~, u2.P~, 0 ;  -u2.P~, u1.P~, 0, -lambda/w2^2 ]               2x4                 (2)
///   J_r_target by the pose of the line's body, from N by RelativeView (3)                2x6
/// Both components are distances to the line divided by the range of the point: they are invariant to the scale, so the
/// residual has no gradient along it.

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/residual/relative_view.hpp"

namespace plumbline {

template <std::floating_point S>
struct CollinearPoint {
  using Scalar = S;
  static constexpr int dim = 2;
  /// For a point and a line of the same anchor `J_r_target` is zero, like the derivative by the anchor of the point.
  struct Linearized {
    Vec<S, dim> r = zeros<S, dim>();
    Mat<S, dim, 6> J_r_target = zeros<S, dim, 6>();
    Vec<S, dim> J_r_lambda = zeros<S, dim>();
    Mat<S, dim, 4> J_r_line = zeros<S, dim, 4>();
  };

  /// (1) for a point P~ in the camera of the line.
  static Vec<S, dim> residual(const Line3<S>& line, const Vec<S, 3>& P, S lambda) {
    const Mat<S, 3, 3> U = line.U().matrix();
    return {dot(column(U, 0), P), dot(column(U, 2), P) + lambda * line.w1() / line.w2()};
  }

  /// For point and line of the same anchor.
  static Linearized linearize(const Line3<S>& line, const Vec<S, 3>& bearing, S lambda) {
    return by_point_and_line(line, bearing, lambda);
  }
  /// `view`: from the anchor of the point to that of the line.
  static Linearized linearize(const RelativeView<S>& view, const Line3<S>& line, const Vec<S, 3>& bearing, S lambda) {
    const Vec<S, 3> P = view.scaled_point(bearing, lambda);
    Linearized out = by_point_and_line(line, P, lambda);
    const Mat<S, 3, 3> U = line.U().matrix();
    Mat<S, dim, 3> N;
    for (int c = 0; c < 3; ++c) {
      N(0, c) = U(c, 0);
      N(1, c) = U(c, 2);
    }
    const Vec<S, 3>& t = view.t_target_anchor();
    out.J_r_lambda += Vec<S, dim>(dot(column(U, 0), t), dot(column(U, 2), t));
    out.J_r_target = view.template target_jacobian<dim>(N, P, lambda);
    return out;
  }

 private:
  /// r, J_r_line, and J_r_lambda with P~ fixed.
  static Linearized by_point_and_line(const Line3<S>& line, const Vec<S, 3>& P, S lambda) {
    const Mat<S, 3, 3> U = line.U().matrix();
    const S a = dot(column(U, 0), P), b = dot(column(U, 1), P), c = dot(column(U, 2), P), d = line.w1() / line.w2();
    Linearized out;
    out.r << a, c + lambda * d;
    out.J_r_lambda << S(0), d;
    out.J_r_line << S(0), -c, b, S(0), -b, a, S(0), -lambda / (line.w2() * line.w2());
    return out;
  }
};

}  // namespace plumbline
