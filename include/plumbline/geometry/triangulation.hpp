#pragma once
/// Inverse range of a point along its anchor bearing, from one or several other views.      docs/math/geometry.md 4
///
///   P(lambda) = R b_a + lambda t,  (R, t) = T_cj_ca; lambda = 1/range, regular at infinity                   (10)
///   two views:  lambda = -((b_j x R b_a) . (b_j x t)) / |b_j x t|^2                                          (11)
///   residual    r_j = n - b_j, n = P/|P|;  dr_j/dlambda = (I - n n^T) t / |P|                                (12)
///   variance    1 / sum_j |dr_j/dlambda|^2 / sigma_j^2                                                       (13)
/// The noise of the anchor bearing is not counted: the point is defined to lie on it.

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
struct TriangulationView {
  SE3<S> T_cj_ca;     ///< anchor camera to this camera
  Vec<S, 3> bearing;  ///< unit, this camera
  S sigma_rad;        ///< its angular noise
};

struct TriangulationOptions {
  double min_significance = 3;  ///< inverse range over its standard deviation: less is lack of parallax
  double max_chi2_per_dof = 9;  ///< worse fits are wrong matches
};

template <class S>
struct Triangulation {
  bool valid = false;
  S inverse_range = 0;  ///< [1/m]
  S variance = 0;       ///< [1/m^2]
  S chi2 = 0;           ///< sum of squared whitened residuals, 2 views - 1 degrees of freedom
};

/// (11) alone; NaN where the baseline points along the bearing.
template <class S>
S two_view_inverse_range(const Vec<S, 3>& bearing_anchor, const TriangulationView<S>& view) {
  const Vec<S, 3> across = view.bearing.cross(view.T_cj_ca.p());
  return -dot(view.bearing.cross(view.T_cj_ca.rotation() * bearing_anchor), across) / squared_norm(across);
}

/// Gauss-Newton on (12) from the view with the most parallax.
template <class S>
Triangulation<S> triangulate(const Vec<S, 3>& bearing_anchor, std::span<const TriangulationView<S>> views,
                             const TriangulationOptions& options = {}) {
  Triangulation<S> out;
  S most = 0;
  for (const TriangulationView<S>& view : views) {
    const S parallax = norm(view.bearing.cross(view.T_cj_ca.p())) / view.sigma_rad;
    if (!(parallax > most)) continue;
    most = parallax;
    out.inverse_range = two_view_inverse_range(bearing_anchor, view);
  }
  if (!(most > 0)) return out;

  bool in_front = true;
  for (int iteration = 0; iteration < 6; ++iteration) {
    S information = 0, gradient = 0;
    out.chi2 = 0;
    in_front = true;
    for (const TriangulationView<S>& view : views) {
      const Vec<S, 3>& t = view.T_cj_ca.p();
      const Vec<S, 3> P = view.T_cj_ca.rotation() * bearing_anchor + out.inverse_range * t;  // (10)
      const S inverse_norm = 1 / norm(P);
      const Vec<S, 3> n = inverse_norm * P, r = n - view.bearing, J = inverse_norm * (t - n * dot(n, t));  // (12)
      const S weight = 1 / (view.sigma_rad * view.sigma_rad);
      information += weight * squared_norm(J);
      gradient += weight * dot(J, r);
      out.chi2 += weight * squared_norm(r);
      in_front = in_front && dot(n, view.bearing) > 0;
    }
    out.variance = 1 / information;  // (13)
    const S step = -gradient * out.variance;
    if (iteration == 5 || !(std::abs(step) > S(0.01) * std::sqrt(out.variance))) break;
    out.inverse_range += step;
  }
  const S dof = static_cast<S>(2 * views.size() - 1), significance = S(options.min_significance);
  out.valid = in_front && out.inverse_range > significance * std::sqrt(out.variance) &&  // false for NaN too
              out.chi2 < S(options.max_chi2_per_dof) * dof;
  return out;
}

}  // namespace plumbline
