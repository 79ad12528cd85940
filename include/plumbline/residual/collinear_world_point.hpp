#pragma once
/// Residual of a point on a line, both with known coordinates: its distance to the line by its range from a camera.
///                                                                                          docs/math/collinear.md
///   lambda = 1/|X - c|,  e = (X - c)/|X - c|;   r = lambda [ u1 . X ; u3 . X + d ]            2x1  [rad]       (5)
///   J_r_point  = lambda (N - r e^T),  N = [u1^T; u3^T]                                       2x3  [rad/m]     (6)
///   J_r_center = lambda r e^T                                                                2x3  [rad/m]     (7)
///   J_r_line   = that of (2)                                                                 2x4
/// c is the center of that camera, in the frame of X and of the line. Invariant to a common scale of all three.

#include <cmath>
#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/collinear_point.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

template <std::floating_point S>
struct CollinearWorldPoint {
  using Scalar = S;
  static constexpr int dim = 2;
  struct Linearized {
    bool valid;
    Vec<S, dim> r;
    Mat<S, dim, 3> J_r_point, J_r_center;
    Mat<S, dim, 4> J_r_line;
  };

  /// Not finite where the point is in the center of the camera.
  static Vec<S, dim> residual(const Line3<S>& line, const Vec<S, 3>& point, const Vec<S, 3>& center) {
    const S lambda = S(1) / norm(Vec<S, 3>(point - center));
    return CollinearPoint<S>::residual(line, Vec<S, 3>(lambda * point), lambda);
  }
  static Linearized linearize(const Line3<S>& line, const Vec<S, 3>& point, const Vec<S, 3>& center) {
    const Vec<S, 3> ray = point - center;
    const S lambda = S(1) / norm(ray);
    const Vec<S, 3> e = lambda * ray;
    const auto scaled = CollinearPoint<S>::linearize(line, Vec<S, 3>(lambda * point), lambda);
    const Mat<S, 3, 3> U = line.U().matrix();
    Linearized out;
    out.r = scaled.r;
    out.J_r_line = scaled.J_r_line;
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < dim; ++k) {
        out.J_r_center(k, c) = lambda * out.r[k] * e[c];                             // (7)
        out.J_r_point(k, c) = lambda * U(c, k == 0 ? 0 : 2) - out.J_r_center(k, c);  // (6)
      }
    }
    out.valid = all_finite(out.r) && all_finite(out.J_r_point);
    return out;
  }
};

static_assert(Residual<CollinearWorldPoint<float>> && Residual<CollinearWorldPoint<double>>);

}  // namespace plumbline
