#pragma once
/// A line from the planes that cameras saw it in.                                           docs/math/line.md
///
///   plane of view j, anchor frame   N_j = R_j^T m_j,  m_j = (b_s x b_e)/|b_s x b_e|,  D_j = m_j . t_j         (22)
///   of two planes                   v = N_1 x N_2,  n = D_1 N_2 - D_2 N_1                                     (23)
///   all views                       r_ji = nh_j . b_ji / sigma_j,  nh_j the unit normal of the line in view j (24)
///   covariance                      (sum J^T J)^-1,  J of (24) by the line's four parameters                  (25)
/// with (R_j, t_j) = T_cj_ca. The pair with the largest angle in units of its noise starts Gauss-Newton on (24).
/// Without parallax, that is for a baseline in the plane of the line or along it, the planes coincide and nothing is
/// valid.

#include <cmath>
#include <cstddef>
#include <span>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class S>
struct LineTriangulationView {
  SE3<S> T_cj_ca;                        ///< anchor camera to this camera
  Vec<S, 3> bearing_start, bearing_end;  ///< unit, this camera; the endpoints need not correspond
  S sigma_rad;                           ///< noise of an endpoint across the segment
};

struct LineTriangulationOptions {
  double min_angle_rad = 0.035;  ///< between two of the planes
  double min_angle_sigmas = 5;   ///< the same in units of the planes' noise
  double min_significance = 3;   ///< inverse depth of both ends over its standard deviation
  double min_distance = 0.02;    ///< to the anchor's center [m]
  double max_chi2_per_dof = 9;   ///< worse fits are wrong matches
};

template <class S>
struct LineTriangulation {
  bool valid = false;
  Line3<S> line;                                  ///< anchor camera
  Mat<S, 4, 4> covariance = zeros<S, 4, 4>();     ///< of its increment
  Vec<S, 2> inverse_depth = zeros<S, 2>();        ///< 1/z at the first view's start and end [1/m]
  Vec<S, 2> sigma_inverse_depth = zeros<S, 2>();  ///< [1/m]
  S chi2 = 0;                                     ///< of (24), 2 views - 4 degrees of freedom
};

/// (22)
template <class S>
struct InterpretationPlane {
  Vec<S, 3> N;  ///< unit, anchor frame
  S D;          ///< [m], N . X + D = 0
  S sigma_rad;  ///< of its angle about the segment's middle

  explicit InterpretationPlane(const LineTriangulationView<S>& view) {
    const Vec<S, 3> cross = view.bearing_start.cross(view.bearing_end);
    const S sine = norm(cross);
    N = view.T_cj_ca.rotation().inverse() * Vec<S, 3>(cross / sine);
    D = dot(cross, view.T_cj_ca.p()) / sine;
    sigma_rad = std::sqrt(S(2)) * view.sigma_rad / sine;
  }
};

/// (23); the sign of the direction is arbitrary.
template <class S>
Plucker<S> intersection(const InterpretationPlane<S>& a, const InterpretationPlane<S>& b) {
  return {a.D * b.N - b.D * a.N, a.N.cross(b.N)};
}

namespace line_triangulation_detail {

/// Derivative by the line's four parameters, from those by its n and v; J_line = d(n; v)/d theta.
template <class S>
Mat<S, 1, 4> by_line(const Vec<S, 3>& by_n, const Vec<S, 3>& by_v, const Mat<S, 6, 4>& J_line) {
  Mat<S, 1, 4> out;
  for (int k = 0; k < 4; ++k) out(0, k) = dot(by_n, block<3, 1>(J_line, 0, k)) + dot(by_v, block<3, 1>(J_line, 3, k));
  return out;
}

}  // namespace line_triangulation_detail

/// The first view is the anchor's own, its T_cj_ca the identity.
template <class S>
LineTriangulation<S> triangulate_line(std::span<const LineTriangulationView<S>> views,
                                      const LineTriangulationOptions& options = {}) {
  using line_triangulation_detail::by_line;
  LineTriangulation<S> out;
  if (views.size() < 2) return out;
  // The best pair is sought with the anchor and every other view: the work is linear in the views.
  const InterpretationPlane<S> anchor(views[0]);
  S most = 0;
  for (std::size_t j = 1; j < views.size(); ++j) {
    const InterpretationPlane<S> plane(views[j]);
    const S sine = norm(anchor.N.cross(plane.N));
    const S significance = sine / elementary::hypot(anchor.sigma_rad, plane.sigma_rad);
    if (!(sine > elementary::sin(S(options.min_angle_rad)) && significance > most)) continue;
    most = significance;
    out.line = Line3<S>(intersection(anchor, plane));
  }
  if (!(most > S(options.min_angle_sigmas))) return out;
  // The direction is that from start to end.
  const Vec<S, 3> along = views[0].bearing_end - views[0].bearing_start;
  if (dot(out.line.direction(), along) < S(0)) {
    const Plucker<S> line = out.line.plucker();
    out.line = Line3<S>(Plucker<S>{-line.n, -line.v});
  }

  bool in_front = true;
  for (int iteration = 0; iteration < 6; ++iteration) {
    DenseNormalEquations<S, 4> equations;
    out.chi2 = 0;
    in_front = true;
    const Plucker<S> line = out.line.plucker();
    const Mat<S, 6, 4> J_line = out.line.plucker_jacobian();
    for (const LineTriangulationView<S>& view : views) {
      const Plucker<S> seen = view.T_cj_ca * line;
      const S inverse_norm = 1 / norm(seen.n);
      const Vec<S, 3> nh = inverse_norm * seen.n;
      const SO3<S> R_ca_cj = view.T_cj_ca.rotation().inverse();
      for (const Vec<S, 3>* b : {&view.bearing_start, &view.bearing_end}) {
        const S r = dot(nh, *b) / view.sigma_rad;                                          // (24)
        const Vec<S, 3> by_n = (inverse_norm / view.sigma_rad) * (*b - dot(nh, *b) * nh);  // in this camera
        const Vec<S, 3> by_v = by_n.cross(view.T_cj_ca.p());
        equations.add(by_line<S>(R_ca_cj * by_n, R_ca_cj * by_v, J_line), Vec<S, 1>(r), S(1));
        out.chi2 += r * r;
      }
      in_front = in_front && dot(view.bearing_start + view.bearing_end, seen.v.cross(seen.n)) > 0;
    }
    Vec<S, 4> step;
    if (!equations.solve(step) || !equations.covariance(out.covariance)) return out;  // (25)
    const bool converged = !(-dot(step, equations.b()) > S(1e-4));  // step^T H step: in units of its own noise
    if (iteration == 5 || converged) break;
    out.line = plus(out.line, step);
  }

  // Inverse depth 1/z = q . m of both ends and its noise; the Jacobians are those of a depth measurement (11).
  const Plucker<S> line = out.line.plucker();
  const Vec<S, 3> q = line.facing_plane();
  const S inverse_square = 1 / squared_norm(line.n);
  const Mat<S, 6, 4> J_line = out.line.plucker_jacobian();
  bool significant = true;
  for (int i = 0; i < 2; ++i) {
    const Vec<S, 3>& b = i == 0 ? views[0].bearing_start : views[0].bearing_end;
    const Vec<S, 3> m = b / b.z();
    const Vec<S, 3> by_n = inverse_square * (m.cross(line.v) - 2 * dot(q, m) * line.n);
    const Vec<S, 3> by_v = inverse_square * line.n.cross(m);
    const Mat<S, 1, 4> J = by_line(by_n, by_v, J_line);
    out.inverse_depth[i] = dot(q, m);
    out.sigma_inverse_depth[i] = std::sqrt(product_transposed(product(J, out.covariance), J)(0, 0));
    significant = significant && out.inverse_depth[i] > S(options.min_significance) * out.sigma_inverse_depth[i];
  }
  const S dof = static_cast<S>(2 * views.size() - 4);
  out.valid = in_front && significant && out.line.distance() > S(options.min_distance) &&  // false for NaN too
              out.chi2 <= S(options.max_chi2_per_dof) * dof + S(1);
  return out;
}

}  // namespace plumbline
