#pragma once
/// Marginalization in square-root form: a prior on the states that stay, in double.     docs/math/solver.md (16)-(18)
///
///   prior         r(x) = r0 + J0 (x [-] x0)                                                                  (16)
///   Q^T [J_m J_r | r] = [R_m  R_mr | r_m]                                                                    (17)
///                       [ 0    J0  | r0 ]    the rows below the pivots of m                                  (18)
/// No inverse, no square of the condition number. Where m is not observed a row has no pivot in it, and stays.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/bounded_matrix.hpp"
#include "plumbline/solver/householder.hpp"

namespace plumbline {

/// (16), J0 upper triangular, dim() x dim(). The x0 of the states is stored with the states.
template <int MaxDim>
struct Prior {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, MaxDim, 1>;
  BoundedMatrix<double, MaxDim, MaxDim> J0;
  Vector r0;

  int dim() const { return int(J0.cols()); }
  bool empty() const { return dim() == 0; }
  void clear() { J0.resize(0, 0), r0.resize(0); }

  /// That of `other` with `count` columns of zeros put in from column `first` on.
  void widen(const Prior& other, int first, int count) {
    J0.resize(int(other.J0.rows()), other.dim() + count);
    for (int c = 0; c < other.dim(); ++c) {
      for (int k = 0; k < int(J0.rows()); ++k) J0(k, c < first ? c : c + count) = other.J0(k, c);
    }
    forget(first, count);
    r0 = other.r0;
  }
  /// Columns [first, first + count) become zero.
  void forget(int first, int count) {
    for (int c = first; c < first + count; ++c) {
      for (int k = 0; k < int(J0.rows()); ++k) J0(k, c) = 0;
    }
  }
  /// False when columns [first, first + count) are zero.
  bool knows(int first, int count) const {
    for (int c = first; c < first + count; ++c) {
      for (int k = 0; k < int(J0.rows()); ++k) {
        if (J0(k, c) != 0) return true;  // also for NaN
      }
    }
    return false;
  }

  /// r0 + J0 e, e = x [-] x0.
  template <class D>
  Vector residual(const Eigen::MatrixBase<D>& e) const {
    Vector r = r0;
    for (int c = 0; c < dim(); ++c) {
      for (int k = 0; k < int(r.size()); ++k) r[k] += e[c] * J0(k, c);
    }
    return r;
  }
  /// J0^T r.
  Vector gradient(const Vector& r) const {
    Vector g(dim());
    for (int c = 0; c < dim(); ++c) g[c] = dot(&J0(0, c), r.data(), int(r.size()));
    return g;
  }

  /// H <- J0^T J0, its lower triangle. Zeros at the bottom of a column are not multiplied.
  template <class D>
  void information(Eigen::MatrixBase<D>& H) const {
    for (int j = 0; j < dim(); ++j) {
      int rows = int(J0.rows());
      while (rows > 0 && J0(rows - 1, j) == 0) --rows;
      for (int i = j; i < dim(); ++i) H(i, j) = rows > 0 ? dot(&J0(0, i), &J0(0, j), rows) : 0.0;
    }
  }
};

/// Collects rows [J | r] over `dim` columns in any order and folds them into a triangle whenever Chunk of them wait, so
/// that memory is bounded. Columns that are exactly zero cost nothing: add the sparsest rows first.
template <int MaxDim, int Chunk>
class Marginalizer {
 public:
  void reset(int dim) {
    PLUMBLINE_ASSERT(dim >= 0 && dim <= MaxDim);
    dim_ = dim;
    waiting_ = 0;
    for (int c = 0; c <= dim_; ++c) std::fill_n(column(c), dim_, 0.0);
  }

  int dim() const { return dim_; }

  /// Rows J over the columns [first_column, first_column + J.cols()), zero elsewhere.
  template <class DJ, class Dr>
  void add_rows(const Eigen::MatrixBase<DJ>& J, const Eigen::MatrixBase<Dr>& r, int first_column = 0) {
    add(r, [&](int from, int to, int n) { write(J, first_column, from, to, n); });
  }
  /// Rows that touch two ranges of columns.
  template <class DJ, class DK, class Dr>
  void add_rows(const Eigen::MatrixBase<DJ>& J, int first_column, const Eigen::MatrixBase<DK>& K, int second_column,
                const Eigen::MatrixBase<Dr>& r) {
    add(r, [&](int from, int to, int n) {
      write(J, first_column, from, to, n);
      write(K, second_column, from, to, n);
    });
  }

  /// Of three.
  template <class DJ, class DK, class DL, class Dr>
  void add_rows(const Eigen::MatrixBase<DJ>& J, int first_column, const Eigen::MatrixBase<DK>& K, int second_column,
                const Eigen::MatrixBase<DL>& L, int third_column, const Eigen::MatrixBase<Dr>& r) {
    add(r, [&](int from, int to, int n) {
      write(J, first_column, from, to, n);
      write(K, second_column, from, to, n);
      write(L, third_column, from, to, n);
    });
  }

  /// The prior over all columns but [first_column, first_column + count), order kept. Consumes the rows: `reset` is
  /// next. False, and no prior, when anything is not finite.
  bool marginalize(int first_column, int count, Prior<MaxDim>& out) {
    PLUMBLINE_ASSERT(first_column >= 0 && count >= 0 && first_column + count <= dim_);
    fold();
    double* const begin = values_.data();
    std::rotate(begin, begin + first_column * rows, begin + (first_column + count) * rows);  // columns [m | r | rhs]
    const int kept = dim_ - count, rank = eliminate_leading_columns(begin, first_column + count, dim_ + 1, rows, count);
    for (int c = 0; c < kept; ++c) {  // the remaining rows are a triangle, or nearly
      const int pivot = rank + c;
      int last = dim_ - 1;
      while (last > pivot && column(count + c)[last] == 0) --last;
      if (last > pivot) eliminate(count + c, pivot, pivot + 1, last - pivot, count + c + 1);
    }
    out.J0.resize(kept, kept);
    out.r0.resize(kept);
    bool finite = true;
    for (int c = 0; c < kept; ++c) {
      for (int k = 0; k < kept; ++k) {
        out.J0(k, c) = k <= c ? column(count + c)[rank + k] : 0.0;
        finite = finite && std::isfinite(out.J0(k, c));
      }
      out.r0[c] = column(dim_)[rank + c];
    }
    if (finite && all_finite(out.r0)) return true;
    out.clear();
    return false;
  }

 private:
  static constexpr int rows = MaxDim + Chunk;

  double* column(int c) { return values_.data() + c * rows; }

  /// write(from, to, n) writes J's rows [from, from + n) to our rows from `to` on, which are zero.
  template <class Dr>
  void add(const Eigen::MatrixBase<Dr>& r, auto&& write) {
    for (int done = 0; done < int(r.size());) {
      if (waiting_ == Chunk) fold();
      const int n = std::min(Chunk - waiting_, int(r.size()) - done), to = dim_ + waiting_;
      for (int c = 0; c < dim_; ++c) std::fill_n(column(c) + to, n, 0.0);
      write(done, to, n);
      for (int k = 0; k < n; ++k) column(dim_)[to + k] = double(r[done + k]);
      waiting_ += n;
      done += n;
    }
  }
  template <class DJ>
  void write(const Eigen::MatrixBase<DJ>& J, int first_column, int from, int to, int n) {
    PLUMBLINE_ASSERT(from + n <= J.rows() && first_column + J.cols() <= dim_);
    for (int c = 0; c < int(J.cols()); ++c) {
      for (int k = 0; k < n; ++k) column(first_column + c)[to + k] = double(J(from + k, c));
    }
  }

  /// The rows that wait go into the triangle of the first dim_ rows.
  void fold() {
    std::array<bool, MaxDim + 1> touched;
    for (int c = 0; c <= dim_; ++c) touched[c] = first_nonzero(column(c) + dim_, waiting_) < waiting_;
    const auto reach = [&](int k, int row) { return touched[k] = touched[k] || column(k)[row] != 0; };
    for (int c = 0; c < dim_; ++c) {
      if (!touched[c]) continue;
      double* const v = column(c) + dim_;
      const double tau = make_reflection(column(c)[c], v, waiting_);
      const int first = c;
      while (++c < dim_ && !reach(c, first)) {
      }
      reflect(tau, v, column(c)[first], column(c) + dim_, waiting_);  // the right-hand side when there is no other
      if (c == dim_) break;
      double* const u = column(c) + dim_;
      const double tau_u = make_reflection(column(c)[c], u, waiting_), product = dot(v, u, waiting_);
      for (int k = c + 1; k <= dim_; ++k) {
        if (reach(k, first) || reach(k, c))
          reflect_twice(tau, v, column(k)[first], tau_u, u, column(k)[c], product, column(k) + dim_, waiting_);
      }
    }
    waiting_ = 0;
  }
  /// n when there is none; NaN is not zero.
  static int first_nonzero(const double* x, int n) {
    int k = 0;
    while (k < n && x[k] == 0) ++k;
    return k;
  }

  /// Zeroes rows [first, first + n) of column c against row `pivot`; columns from `next` on follow.
  void eliminate(int c, int pivot, int first, int n, int next) {
    const double tau = make_reflection(column(c)[pivot], column(c) + first, n);
    for (int k = next; k <= dim_; ++k) reflect(tau, column(c) + first, column(k)[pivot], column(k) + first, n);
    std::fill_n(column(c) + first, n, 0.0);
  }

  int dim_ = 0, waiting_ = 0;
  std::array<double, std::size_t(rows) * (MaxDim + 1)> values_;  // column-major: triangle on top, waiting rows below it
};

}  // namespace plumbline
