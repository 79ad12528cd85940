#pragma once
/// Normal equations of one small state of D parameters (a pose): H d = -b.                  docs/math/solver.md (6)-(8)
///
///   H = sum w J^T J,  b = sum w J^T r,  cost = 1/2 sum rho
/// The state loops over its rows, calls `add` and `add_cost`, then `solve`, and applies d with `plus`.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/cholesky.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class S, int D>
class DenseNormalEquations {
 public:
  using Scalar = S;
  static constexpr int dim = D;

  DenseNormalEquations() { reset(); }

  void reset() {
    std::fill_n(H_.data(), D * D, S(0));
    std::fill_n(b_.data(), D, S(0));
    sum_rho_ = S(0);
  }

  template <class T, int R>
  void add(const Mat<T, R, D>& J, const Vec<T, R>& r, S weight) {
    for (int k = 0; k < R; ++k) {
      S row[D];
      for (int i = 0; i < D; ++i) row[i] = S(J(k, i));
      for (int j = 0; j < D; ++j) {
        const S scale = weight * row[j];
        for (int i = 0; i < D; ++i) H_(i, j) += row[i] * scale;
        b_[j] += scale * S(r[k]);
      }
    }
  }
  /// Adds the equations of the first parameters alone.
  template <int Leading>
  void add(const DenseNormalEquations<S, Leading>& system) {
    static_assert(Leading <= D, "plumbline: these equations have more parameters");
    for (int j = 0; j < Leading; ++j) {
      for (int i = 0; i < Leading; ++i) H_(i, j) += system.H()(i, j);
      b_[j] += system.b()[j];
    }
    sum_rho_ += 2 * system.cost();
  }
  /// The state was moved by d, and its rows are still what they were to first order: b + H d. The cost stays.
  void move(const Vec<S, D>& d) {
    for (int j = 0; j < D; ++j) {
      for (int i = 0; i < D; ++i) b_[i] += H_(i, j) * d[j];
    }
  }
  /// 1/2 sum rho over all that was given to `add_cost`.
  S cost() const { return sum_rho_ / 2; }
  void add_cost(S rho) { sum_rho_ += rho; }

  /// (H + mu clip(diag H)) d = -b. False, and d undefined, when H is singular or anything is not finite.
  bool solve(Vec<S, D>& d, S mu = S(0)) const {
    Cholesky<S, D> factor;
    Vec<S, D> damping;
    for (int k = 0; k < D; ++k) damping[k] = mu * damping_scale(H_(k, k));
    if (!factor.compute(H_, damping)) return false;
    for (int k = 0; k < D; ++k) d[k] = -b_[k];
    factor.solve_in_place(d);
    return all_finite(d);
  }

  /// H^-1. False when H is singular.
  bool covariance(Mat<S, D, D>& covariance) const {
    Cholesky<S, D> factor;
    Vec<S, D> column;
    std::fill_n(column.data(), D, S(0));  // no damping
    if (!factor.compute(H_, column)) return false;
    for (int c = 0; c < D; ++c) {
      for (int k = 0; k < D; ++k) column[k] = S(k == c);
      factor.solve_in_place(column);
      for (int k = 0; k < D; ++k) covariance(k, c) = column[k];
    }
    return all_finite(covariance);
  }

  const Mat<S, D, D>& H() const { return H_; }
  const Vec<S, D>& b() const { return b_; }

 private:
  Mat<S, D, D> H_;
  Vec<S, D> b_;
  S sum_rho_;
};

}  // namespace plumbline
