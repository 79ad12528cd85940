#pragma once
// Camera pose from points, and from points in space that lie on segments of the image: EPnP (Lepetit et al. 2009) with
// the line and collinear rows of LAP-SLAM. Measured beside what the map uses: docs/decisions/145.
//
//   X_i = sum_j alpha_ij C_j,  sum_j alpha_ij = 1;   C_0 the mean of all X, C_j - C_0 principal axes x deviations
//   point, unit bearing b, u and v normal to it and each other:  sum_j alpha_ij u . C_j^cam = 0, the same with v   (1)
//   X on a segment, l the unit normal of the segment's plane:    sum_j alpha_ij l . C_j^cam = 0                    (2)
//   C^cam = sum_k beta_k v_k,  v_k the null space of the rows;  |C_a^cam - C_b^cam| = |C_a - C_b| tells beta       (3)
// A line gives (2) twice, for two of its points, a collinear point once. The error of a row is range x angle, so a row
// is weighted by 1/(range sigma), with the ranges of a first solution. N = 1 .. 4 vectors v_k are tried, and three
// control points where the points are nearly in a plane; the pose with the smallest cost is taken. No outliers.

#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/SVD>

#include "line_assisted_rows.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/rigid_alignment.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline::test {

template <class S>
struct LineAssistedPose {
  bool valid = false;
  SE3<S> T_cam_world;
  S cost = std::numeric_limits<S>::infinity();  ///< sum of squared errors by their sigmas
};

/// EPnP with C control points: the mean, and one on each of the first C - 1 principal axes.
template <class S, int C>
class EpnpSolver {
 public:
  static constexpr int unknowns = 3 * C, pairs = C * (C - 1) / 2;

  EpnpSolver(const LineAssistedRows<S>& problem, const RowShape<S>& shape) : problem_(problem), shape_(shape) {}

  /// Offers its poses to `best`. `T_before`: a solution whose ranges weight the rows, or null.
  void solve(const SE3<S>* T_before, LineAssistedPose<S>& best) {
    set_zero(R_);
    problem_.for_each_row([&](const Vec<S, 3>& normal, const Vec<S, 3>& p_world, S sigma_rad) {
      const S range = T_before ? norm(Vec<S, 3>(*T_before * p_world)) : S(1);
      const Vec<S, 3> in_axes = shape_.axes.transpose() * (p_world - shape_.mean);
      std::array<S, std::size_t(C)> alpha{S(1)};
      for (int j = 1; j < C; ++j) {
        alpha[std::size_t(j)] = in_axes[j - 1] / shape_.deviation[j - 1];
        alpha[0] -= alpha[std::size_t(j)];
      }
      Vec<S, unknowns> row;
      for (int k = 0; k < unknowns; ++k) row[k] = alpha[std::size_t(k / 3)] * normal[k % 3] / (range * sigma_rad);
      add(row);
    });
    if (!all_finite(R_)) return;
    const Eigen::JacobiSVD<Mat<S, unknowns, unknowns>> svd(R_, Eigen::ComputeFullV);
    for (int k = 0; k < C; ++k) {
      for (int i = 0; i < unknowns; ++i) null_[std::size_t(k)][i] = svd.matrixV()(i, unknowns - 1 - k);
    }
    try_vectors<1>(best);
    try_vectors<2>(best);
    try_vectors<3>(best);
    if constexpr (C == 4) try_vectors<4>(best);
  }

 private:
  /// One row more of the triangular factor, by Givens rotations: squares of rows would cost half of the precision.
  void add(Vec<S, unknowns>& row) {
    for (int k = 0; k < unknowns; ++k) {
      if (row[k] == S(0)) continue;
      const S length = std::sqrt(R_(k, k) * R_(k, k) + row[k] * row[k]), c = R_(k, k) / length, s = row[k] / length;
      for (int j = k; j < unknowns; ++j) {
        const S above = R_(k, j), below = row[j];
        R_(k, j) = c * above + s * below;
        row[j] = c * below - s * above;
      }
    }
  }

  Vec<S, 3> control(int vector, int point) const { return segment<3>(null_[std::size_t(vector)], 3 * point); }
  void for_each_pair(auto&& visit) const {
    for (int a = 0; a < C; ++a)
      for (int b = 0; b < a; ++b) visit(a, b, distance2(a, b));
  }
  S distance2(int a, int b) const {
    const S da = shape_.deviation[a - 1], db = b > 0 ? shape_.deviation[b - 1] : S(0);
    return da * da + db * db;
  }

  /// Products of the first N betas: all, or those with the first one where the distances are too few.
  template <int N>
  void try_vectors(LineAssistedPose<S>& best) const {
    constexpr bool all = N * (N + 1) / 2 <= pairs;
    constexpr int products = all ? N * (N + 1) / 2 : N;
    DenseNormalEquations<S, products> linear;
    for_each_pair([&](int a, int b, S d2) {
      Mat<S, 1, products> row;
      for (int i = 0, k = 0; i < (all ? N : 1); ++i) {
        const Vec<S, 3> d_i = control(i, a) - control(i, b);
        for (int j = i; j < N; ++j, ++k)
          row(0, k) = S(j == i ? 1 : 2) * dot(d_i, Vec<S, 3>(control(j, a) - control(j, b)));
      }
      linear.add(row, Vec<S, 1>(-d2), S(1));
    });
    Vec<S, products> product;
    Vec<S, N> beta = zeros<S, N>();
    if (!linear.solve(product)) return;
    int pivot = 0, at = 0;  // the largest square
    for (int i = 0, k = 0; i < (all ? N : 1); k += N - i, ++i) {
      if (std::abs(product[k]) > std::abs(product[at])) pivot = i, at = k;
    }
    const S root = std::copysign(std::sqrt(std::abs(product[at])), product[at]);
    if (!(std::abs(root) > S(0))) return;
    for (int i = 0, k = 0; i < (all ? N : 1); ++i) {
      for (int j = i; j < N; ++j, ++k) {
        if (i == pivot) beta[j] = product[k] / root;
        if (j == pivot) beta[i] = product[k] / root;
      }
    }
    polish(beta);
    offer(beta, best);
  }

  /// Gauss-Newton on the squared distances (3).
  template <int N>
  void polish(Vec<S, N>& beta) const {
    for (int iteration = 0; iteration < 6; ++iteration) {
      DenseNormalEquations<S, N> equations;
      for_each_pair([&](int a, int b, S d2) {
        Vec<S, 3> d = zeros<S, 3>();
        for (int k = 0; k < N; ++k) d += beta[k] * (control(k, a) - control(k, b));
        Mat<S, 1, N> J;
        for (int k = 0; k < N; ++k) J(0, k) = 2 * dot(d, Vec<S, 3>(control(k, a) - control(k, b)));
        equations.add(J, Vec<S, 1>(squared_norm(d) - d2), S(1));
      });
      Vec<S, N> step;
      if (!equations.solve(step, S(1e-6))) return;
      beta += step;
    }
  }

  /// The pose that carries the control points: with the axes as pairs of opposite points this is the alignment of all.
  template <int N>
  void offer(const Vec<S, N>& beta, LineAssistedPose<S>& best) const {
    std::array<Vec<S, 3>, std::size_t(C)> in_camera;
    for (int j = 0; j < C; ++j) {
      Vec<S, 3>& p = in_camera[std::size_t(j)];
      p = zeros<S, 3>();
      for (int k = 0; k < N; ++k) p += beta[k] * control(k, j);
    }
    for (const S sign : {S(1), S(-1)}) {  // a null space has none
      RigidAlignment<S> alignment;
      for (int j = 1; j < C; ++j) {
        const Vec<S, 3> axis = shape_.deviation[j - 1] * column(shape_.axes, j - 1);
        const Vec<S, 3> arm = sign * (in_camera[std::size_t(j)] - in_camera[0]);
        alignment.add(arm, axis);
        alignment.add(Vec<S, 3>(-arm), Vec<S, 3>(-axis));
      }
      const auto aligned = alignment.solve(/*with_scale=*/false, S(1e-6));
      if (!aligned.valid) return;
      const SO3<S> R = aligned.S_p_q.rotation();
      const SE3<S> T(R, sign * in_camera[0] - R * shape_.mean);
      const S cost = problem_.cost(T);
      if (cost < best.cost) best = {true, T, cost};
    }
  }

  const LineAssistedRows<S>& problem_;
  const RowShape<S>& shape_;
  Mat<S, unknowns, unknowns> R_;
  std::array<Vec<S, unknowns>, std::size_t(C)> null_;
};

/// The pose of the least cost. Not valid for fewer than 11 rows (8 in a plane), for points on one line, and where no
/// pose has all points in front. Rows with a number that is not finite are left out.
template <class S>
LineAssistedPose<S> line_assisted_epnp(std::span<const PoseCorrespondence<S>> points,
                                       std::span<const PointOnSegment<S>> on_segments) {
  const LineAssistedRows<S> problem{points, on_segments};
  const RowShape<S> shape(problem);
  LineAssistedPose<S> best;
  const S largest = shape.deviation[0];
  if (!(shape.deviation[1] > S(1e-3) * largest)) return best;
  constexpr S nearly_flat = S(0.05);
  const S flat = 10 * std::sqrt(std::numeric_limits<S>::epsilon());
  for (const bool is_weighted : {false, true}) {
    if (is_weighted && !best.valid) break;
    const SE3<S> T_before = best.T_cam_world;
    const SE3<S>* const weights = is_weighted ? &T_before : nullptr;
    if (shape.deviation[2] > flat * largest && shape.rows >= 11) EpnpSolver<S, 4>(problem, shape).solve(weights, best);
    if (shape.deviation[2] < nearly_flat * largest && shape.rows >= 8)
      EpnpSolver<S, 3>(problem, shape).solve(weights, best);
  }
  return best;
}

}  // namespace plumbline::test
