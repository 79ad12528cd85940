#pragma once
/// Collinearity constraints between the points of one store and the lines of another one in a window: r of
/// residual/collinear_point.hpp for every member of a line when both landmarks are estimated. The point is eliminated
/// first, then the line.                                               docs/math/collinear.md, docs/math/solver.md (13)
///
/// A point is constrained to one line, the nearer of two at a corner; it is chosen before an optimization.

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/residual/collinear_point.hpp"
#include "plumbline/solver/block_rows.hpp"

namespace plumbline {

template <class LineStore, class PointStore>
class CollinearTerms {
 public:
  using Kind = typename LineStore::Kind;
  using S = typename Kind::S;
  using LineTerms = WindowTerms<LineStore>;
  using PointTerms = WindowTerms<PointStore>;
  using Views = typename LineTerms::Views;

  /// Chooses the line of each point.
  void choose(LineStore& lines, const PointStore& points, const Views& views) {
    ties_.clear();
    of_point_.fill(none);
    for (std::size_t i = 0; i < lines.landmarks().size(); ++i) {
      auto& line = lines.landmarks()[i];
      if (!line.takes_part()) continue;
      for (auto& member : line.appearance.points) {
        const int p = index_of(points, member);
        if (p < 0 || !points.landmarks()[p].takes_part()) continue;
        const S error = squared_norm(whitened(line, points.landmarks()[p], member, views));
        if (!(error < max_error * max_error)) continue;
        int& tie = of_point_[static_cast<std::size_t>(p)];
        if (tie == none) {
          tie = static_cast<int>(ties_.size());
          ties_.push_back({static_cast<int>(i), p, member, error, {}, zeros<double, line_dim>()});
        } else if (error < ties_[tie].error) {
          ties_[tie].line = static_cast<int>(i);
          ties_[tie].member = member;
          ties_[tie].error = error;
        }
      }
    }
  }

  /// Computes the weighted rows at the current state; returns their cost.
  double linearize(const LineStore& lines, const PointStore& points, const Views& views) {
    double cost = 0;
    for (Tie& tie : ties_) {
      const auto& line = lines.landmarks()[tie.line];
      const auto& point = points.landmarks()[tie.point];
      auto& lin = tie.rows;
      lin = line.anchor == point.anchor
                ? CollinearPoint<S>::linearize(line.geometry.line, point.geometry.bearing, point.geometry.inverse_range)
                : CollinearPoint<S>::linearize(views(point.anchor, line.anchor), line.geometry.line,
                                               point.geometry.bearing, point.geometry.inverse_range);
      lin.r[0] -= tie.member.offset;
      const S sigma = tie.member.sigma(), squared = squared_norm(lin.r) / (sigma * sigma);
      const S scale = std::sqrt(Kind::point_loss.weight(squared)) / sigma;
      cost += double(Kind::point_loss.rho(squared)) / 2;
      lin.r *= scale;
      lin.J_r_target *= scale;
      lin.J_r_lambda *= scale;
      lin.J_r_line *= scale;
    }
    return cost;
  }

  /// Sets all residuals to zero, keeping the Jacobians.
  void clear_residuals() {
    for (Tie& tie : ties_) set_zero(tie.rows.r);
  }

  double cost(const LineStore& lines, const PointStore& points, const Views& views) const {
    double sum = 0;
    for (const Tie& tie : ties_) {
      sum += double(Kind::point_loss.rho(
          squared_norm(whitened(lines.landmarks()[tie.line], points.landmarks()[tie.point], tie.member, views))));
    }
    return sum / 2;
  }

  /// Eliminates point and line from the rows of every constraint, after both were eliminated from their own rows, and
  /// adds the remaining rows on the poses to `normal`.
  template <class Normal>
  void eliminate(const LineStore& lines, LineTerms& line_terms, const PointStore& points, PointTerms& point_terms,
                 const typename LineTerms::Pairs& pairs, Normal& normal) {
    for (Tie& tie : ties_) {
      auto& of_line = line_terms.elimination(tie.line);
      auto& of_point = point_terms.elimination(tie.point);
      of_line.complete(pairs);
      of_point.complete(pairs);
      const int line_anchor = lines.landmarks()[tie.line].anchor, point_anchor = points.landmarks()[tie.point].anchor;
      Rows<line_dim> rows;
      rows.touched.reset();
      std::array<Vec<double, 1>, 2> by_point;
      for (std::size_t k = 0; k < 2; ++k) {
        rows.r[k] = double(tie.rows.r[k]);
        by_point[k][0] = double(tie.rows.J_r_lambda[k]);
        for (int c = 0; c < line_dim; ++c) rows.J_other[k][c] = double(tie.rows.J_r_line(k, c));
        if (line_anchor == point_anchor) continue;
        const auto& transport = pairs.transport(point_anchor, line_anchor);
        for (int c = 0; c < pose_dim; ++c) rows.J[line_anchor][k][c] = double(tie.rows.J_r_target(k, c));
        rows.J[point_anchor][k].noalias() = -transport.transpose() * rows.J[line_anchor][k];
        rows.touched[line_anchor] = rows.touched[point_anchor] = true;
      }
      tie.by_line = of_point.absorb(by_point, rows).transpose();
      Rows<1> left{rows.touched, rows.J, {}, rows.r};
      for (auto& nothing : left.J_other) set_zero(nothing);
      of_line.absorb(rows.J_other, left);
      left.add_to(normal);
    }
  }

  /// Computes the steps of the points from those of their lines; returns the change of the predicted decrease.
  template <class Vector>
  double solve(const LineTerms& line_terms, PointTerms& point_terms, const Vector& d, int stride) {
    double change = 0;
    for (const Tie& tie : ties_) {
      const Vec<S, line_dim>& d_line = line_terms.step_of(tie.line);
      Vec<double, 1> by_line = zeros<double, 1>();
      for (int c = 0; c < line_dim; ++c) by_line[0] += tie.by_line[c] * double(d_line[c]);
      change += point_terms.solve_again(tie.point, d, stride, by_line);
    }
    return change;
  }

  /// After convergence: removes members that did not fit their line three times in a row.
  void finish(LineStore& lines, const PointStore& points, const Views& views) {
    for (auto& line : lines.landmarks()) {
      if (!line.takes_part()) continue;
      auto& members = line.appearance.points;
      for (std::size_t k = members.size(); k-- > 0;) {
        const int p = index_of(points, members[k]);
        if (p < 0 || !points.landmarks()[p].takes_part()) continue;
        const bool fits = norm(whitened(line, points.landmarks()[p], members[k], views)) < max_fit_error;
        members[k].misfits = fits ? 0 : members[k].misfits + 1;
        if (members[k].misfits >= max_misfits) members.swap_remove(k);
      }
    }
  }

 private:
  static constexpr int none = -1, line_dim = Kind::dim, pose_dim = state::Pose::dim;
  static constexpr S max_fit_error = S(3);  ///< of a member; chi-square quantile 98.9 %, 2 degrees of freedom
  /// Whitened error beyond which a point is not constrained; tuned: docs/decisions/136 (chosen).
  static constexpr S max_error = S(30);
  static constexpr int max_misfits = 3;  ///< in a row; tuned: docs/decisions/136 (chosen)

  using Member = typename Kind::Member;
  template <int OtherDim>
  using Rows = BlockRows<double, 2, pose_dim, LineStore::slots, OtherDim>;

  /// One constraint.
  struct Tie {
    int line, point;  ///< indices in their stores
    Member member;
    S error;  ///< squared whitened error when it was chosen
    typename CollinearPoint<S>::Linearized rows;
    Vec<double, line_dim> by_line;  ///< B of (13)
  };

  /// Residual of (3) divided by sigma.
  static Vec<S, 2> whitened(const auto& line, const auto& point, const Member& member, const Views& views) {
    const auto& at = point.geometry;
    const Vec<S, 3> P = line.anchor == point.anchor
                            ? at.bearing
                            : views(point.anchor, line.anchor).scaled_point(at.bearing, at.inverse_range);
    const Vec<S, 2> r = CollinearPoint<S>::residual(line.geometry.line, P, at.inverse_range);
    return Vec<S, 2>(r[0] - member.offset, r[1]) / member.sigma();
  }

  FixedVector<Tie, PointStore::capacity> ties_;
  std::array<int, PointStore::capacity> of_point_;  ///< index of the point's constraint
};

}  // namespace plumbline
