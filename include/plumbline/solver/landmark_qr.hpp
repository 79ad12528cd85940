#pragma once
/// Thin QR of the rows of one landmark by Householder reflections, damped as in Levenberg-Marquardt.
///                                                                                        docs/math/solver.md (10)
///   [J; sqrt(mu) D] = Q1 R,   D^2 = clip(diag J^T J) as in (7)
/// Rows are kept as S, the arithmetic is that of Acc.

#include <algorithm>
#include <array>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/householder.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class S, int Dim, int MaxRows, class Acc>
class LandmarkQr {
 public:
  using Rows = std::array<std::array<S, Dim>, MaxRows>;
  using Column = Vec<Acc, Dim>;  ///< one number for each of the landmark's parameters
  using Columns = std::array<std::array<Acc, MaxRows + Dim>, Dim>;  ///< those of J, below them of the damping

  /// Reflections that make J triangular, with R and the damping: column k of W below its diagonal is v_k without its
  /// leading 1. The rows of the damping, if any, are last. Returns the number of rows, 0 when J is not of full rank.
  int triangularize(const Rows& J, int rows, Acc mu, Columns& W, Column& tau) {
    Column squared_norm;
    int n = rows;
    for (int l = 0; l < Dim; ++l) {
      for (int k = 0; k < rows; ++k) W[l][k] = Acc(J[k][l]);
      squared_norm[l] = plumbline::dot(W[l].data(), W[l].data(), rows);
      damping_[l] = damping_scale(squared_norm[l]);
      squared_norm[l] += mu * damping_[l];
    }
    if (Dim > 1 && mu > 0) {
      for (int l = 0; l < Dim; ++l, ++n) {
        for (int c = 0; c < Dim; ++c) W[c][n] = c == l ? std::sqrt(mu * damping_[l]) : Acc(0);
      }
    }
    if (n < Dim) return 0;
    for (int k = 0; k < Dim; ++k) {
      Acc* const pivot = W[k].data() + k;
      tau[k] = make_reflection(*pivot, pivot + 1, n - k - 1);
      if (!(std::abs(*pivot) > rank_tolerance<Acc> * std::sqrt(squared_norm[k]))) return 0;
      for (int c = k + 1; c < Dim; ++c) reflect(tau[k], pivot + 1, W[c][k], W[c].data() + k + 1, n - k - 1);
      for (int c = 0; c < Dim; ++c) R_[k][c] = c < k ? Acc(0) : W[c][k];
    }
    return n;
  }
  /// Q1, R and the damping. False when J is not of full rank.
  bool factorize(const Rows& J, int rows, Acc mu, Columns& Q) {
    if constexpr (Dim == 1) {  // the damping has no row of its own: what it would add to Q1 meets zeros
      Acc squared_norm = Acc(0);
      for (int k = 0; k < rows; ++k) squared_norm += (Q[0][k] = Acc(J[k][0])) * Q[0][k];
      damping_[0] = damping_scale(squared_norm);
      squared_norm += mu * damping_[0];
      R_[0][0] = std::sqrt(squared_norm);
      const Acc inverse = Acc(1) / R_[0][0];
      for (int k = 0; k < rows; ++k) Q[0][k] *= inverse;
      return squared_norm > Acc(0);
    } else {
      Columns V;
      Column tau;
      const int n = triangularize(J, rows, mu, V, tau);
      for (int l = 0; n > 0 && l < Dim; ++l) {  // Q1 = H_1 ... H_dim [I; 0]
        Acc* const q = Q[l].data();
        std::fill_n(q, l, Acc(0));
        q[l] = 1 - tau[l];
        for (int k = l + 1; k < n; ++k) q[k] = -tau[l] * V[l][k];
        for (int k = l - 1; k >= 0; --k) reflect(tau[k], V[k].data() + k + 1, q[k], q + k + 1, n - k - 1);
      }
      return n > 0;
    }
  }

  /// x <- R^-1 x
  void solve(Column& x) const {
    for (int k = Dim - 1; k >= 0; --k) {
      x[k] /= R_[k][k];
      for (int l = 0; l < k; ++l) x[l] -= x[k] * R_[l][k];
    }
  }
  /// Of R, for rows that reflect into it.
  Column& row(int k) { return R_[k]; }
  const Column& damping() const { return damping_; }  ///< diagonal of D^2

 private:
  std::array<Column, Dim> R_;  ///< row by row
  Column damping_;
};

}  // namespace plumbline
