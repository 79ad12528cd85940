#pragma once
/// Initialization of a line through points: in the plane of its anchor's segment, through its located members.
///                                                                                        docs/math/collinear.md

#include <cstddef>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/frontend/line_location.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/collinear_point.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

namespace detail {

/// A member relative to the anchor of the line.
template <class S>
struct MemberInAnchor {
  RelativeView<S> view;    ///< from the anchor of the point to that of the line
  Vec<S, 3> bearing;       ///< in the anchor of the point
  S lambda, sigma_lambda;  ///< inverse range of the point [1/m]
  S offset, sigma;         ///< of collinear_kind.hpp (3) [rad]

  /// Rows of the collinearity constraint, whitened by its sigma and that of the range of the point.
  struct Rows {
    Vec<S, 2> r;
    Mat<S, 2, 4> J_line;
  };
  Rows rows(const Line3<S>& line) const {
    const auto lin = CollinearPoint<S>::linearize(view, line, bearing, lambda);
    const Vec<S, 2> w = {S(1) / elementary::hypot(sigma, lin.J_r_lambda[0] * sigma_lambda),
                         S(1) / elementary::hypot(sigma, lin.J_r_lambda[1] * sigma_lambda)};
    Rows out{cwise_product(w, lin.r - Vec<S, 2>(offset, S(0))), lin.J_r_line};
    for (int c = 0; c < 4; ++c) out.J_line(0, c) *= w[0], out.J_line(1, c) *= w[1];
    return out;
  }
};

}  // namespace detail

/// Locates the landmark if at least two of its members, and half of them, are on one line within 3 sigma. `points`: the
/// store of the members.
template <class Landmark, class S>
void locate_collinear(const SE3<S>& T_body_cam, const auto& window, Landmark& landmark, const auto& points) {
  using Kind = typename Landmark::Kind;
  const auto& seen = landmark.seen_by_anchor();
  if (!seen.valid || seen.from_points) return;
  const LineReprojection<S>& pixels = seen.pixels.measured;
  FixedVector<detail::MemberInAnchor<S>, Kind::max_points> members;
  Vec<S, 3> start = zeros<S, 3>(), end = start;
  S from = S(0), to = S(0);
  for (auto& member : landmark.appearance.points) {
    const int i = index_of(points, member);
    if (i < 0 || !points.landmarks()[static_cast<std::size_t>(i)].located) continue;
    const auto& point = points.landmarks()[static_cast<std::size_t>(i)];
    const auto& at = point.geometry;
    const RelativeView<S> to_line(window.T_world_body(point.anchor), window.T_world_body(landmark.anchor), T_body_cam);
    const Vec<S, 3> X = to_line.scaled_point(at.bearing, at.inverse_range) / at.inverse_range;
    const S along = dot(pixels.bearing_end - pixels.bearing_start, X) / norm(X);
    if (members.empty() || along < from) from = along, start = X;
    if (members.empty() || along > to) to = along, end = X;
    members.push_back({to_line, at.bearing, at.inverse_range, at.sigma_inverse_range, member.offset, member.sigma()});
  }
  if (members.size() < 2) return;
  Line3<S> line = Line3<S>::through(start, end);
  if (!line.is_finite()) return;
  Mat<double, 4, 4> covariance;
  constexpr int iterations = 4;        // numerics: Gauss-Newton from an initial value through two members
  constexpr S max_member_chi2 = S(9);  // chi-square quantile 98.9 %, 2 degrees of freedom
  for (int iteration = 0; iteration < iterations; ++iteration) {
    DenseNormalEquations<double, 4> system;
    detail::add_in_anchor(seen.pixels, line, system);
    for (const auto& member : members) {
      const auto rows = member.rows(line);
      system.add(rows.J_line, rows.r, Kind::point_loss.weight(squared_norm(rows.r)));
    }
    Vec<double, 4> step;
    if (!system.solve(step) || !system.covariance(covariance)) return;
    line = line.plus(cast_to<S>(step));
  }
  int straight = 0;
  for (const auto& member : members) straight += squared_norm(member.rows(line).r) < max_member_chi2;
  if (straight < 2 || 2 * straight < static_cast<int>(members.size())) return;
  detail::adopt_line(landmark, line, cast_to<S>(covariance));
}

}  // namespace plumbline
