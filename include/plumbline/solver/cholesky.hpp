#pragma once
/// Cholesky factor A = L L^T of a symmetric positive definite matrix of at most MaxDim rows, without heap.
///
///   L_ij L_jj^T = A_ij - sum_k L_ik L_jk^T,   k from the first block that rows i and j both have   docs/math/solver.md
///   (9)
/// in blocks of 4 x 4, row by row. A row of L starts where the row of A does: what stands before its first number that
/// is not zero stays zero, and costs nothing. An order of the parameters that makes rows short makes the factor cheap.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class S, int MaxDim>
class Cholesky {
 public:
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, MaxDim, 1>;

  /// Factor of P (A + diag(damping)) P^T; reads the lower triangle of A (dim x dim). Row k of the factor belongs to
  /// parameter order(k). False when A is not positive definite to the precision of S, or not finite.
  template <class DA, class Dd, class Order>
  bool compute(const Eigen::MatrixBase<DA>& A, const Eigen::MatrixBase<Dd>& damping, Order&& order) {
    PLUMBLINE_ASSERT(A.rows() <= MaxDim && A.cols() == A.rows() && damping.size() == A.rows());
    dim_ = int(A.rows());
    for (int i = 0; i < tiles(); ++i) {
      int first = i;
      for (int j = i; j >= 0; --j) {
        if (read(A.derived(), damping.derived(), order, i, j, at(i, j))) first = j;
      }
      first_[i] = first;
      S* const inverse_diagonal = inverse_diagonal_.data();
      for (int j = first; j < i; ++j) {
        subtract_products(i, j, at(i, j));
        divide(at(i, j), at(j, j), inverse_diagonal + j * width);
      }
      const Tile original = at(i, i);
      subtract_products(i, i, at(i, i));
      if (!factorize(at(i, i), original, inverse_diagonal + i * width)) return false;
    }
    return true;
  }
  template <class DA, class Dd>
  bool compute(const Eigen::MatrixBase<DA>& A, const Eigen::MatrixBase<Dd>& damping) {
    return compute(A, damping, [](int k) { return k; });
  }

  /// x <- A^-1 x in the order of the factor, after compute.
  template <class D>
  void solve_in_place(Eigen::MatrixBase<D>& x) const {
    Padded y = padded(x);
    forward(y, 0);
    for (int i = tiles() - 1; i >= 0; --i) {
      S* const y_i = y.data() + i * width;
      const Tile& L = at(i, i);
      for (int c = width - 1; c >= 0; --c) {
        for (int k = c + 1; k < width; ++k) y_i[c] -= L(k, c) * y_i[k];
        y_i[c] *= inverse_diagonal_[i * width + c];
      }
      for (int k = first_[i]; k < i; ++k) subtract_transposed(at(i, k), y_i, y.data() + k * width);
    }
    for (int k = 0; k < dim_; ++k) x[k] = y[k];
  }

  /// x <- L^-1 x, where the numbers of x before `first` are zero.
  template <class D>
  void forward_in_place(Eigen::MatrixBase<D>& x, int first) const {
    Padded y = padded(x);
    forward(y, first / width);
    for (int k = 0; k < dim_; ++k) x[k] = y[k];
  }

 private:
  static constexpr int width = 4, max_tiles = (MaxDim + width - 1) / width;
  /// One block, column by column.
  struct Tile {
    S values[width * width];
    S& operator()(int r, int c) { return values[c * width + r]; }
    const S& operator()(int r, int c) const { return values[c * width + r]; }
  };
  using Padded = std::array<S, std::size_t(max_tiles) * width>;

  int tiles() const { return (dim_ + width - 1) / width; }
  Tile& at(int i, int j) { return tiles_[std::size_t(i * (i + 1) / 2 + j)]; }
  const Tile& at(int i, int j) const { return tiles_[std::size_t(i * (i + 1) / 2 + j)]; }

  template <class D>
  Padded padded(const Eigen::MatrixBase<D>& x) const {
    Padded y{};
    for (int k = 0; k < dim_; ++k) y[k] = x[k];
    return y;
  }

  /// Block (i, j) of the matrix, the identity beyond its end. False when it is zero.
  template <class DA, class Dd, class Order>
  bool read(const DA& A, const Dd& damping, Order&& order, int i, int j, Tile& out) const {
    bool any = i == j;
    for (int c = 0; c < width; ++c) {
      for (int r = 0; r < width; ++r) {
        const int k = i * width + r, l = j * width + c;
        if (k >= dim_ || l >= dim_) {
          out(r, c) = S(k == l);
          continue;
        }
        const int p = order(k), q = order(l);
        const S value = p > q ? A(p, q) : A(q, p);
        out(r, c) = p == q ? value + damping[p] : value;
        any = any || value != S(0);  // true for NaN
      }
    }
    return any;
  }

  /// T -= sum_k L_ik L_jk^T, k < j
  void subtract_products(int i, int j, Tile& T) const {
    Tile sum = T;
    for (int k = first_[i] > first_[j] ? first_[i] : first_[j]; k < j; ++k) {
      const Tile &A = at(i, k), &B = at(j, k);
      for (int c = 0; c < width; ++c) {
        for (int r = 0; r < width; ++r) {
          S value = sum(r, c);
          for (int n = 0; n < width; ++n) value -= A(r, n) * B(c, n);
          sum(r, c) = value;
        }
      }
    }
    T = sum;
  }
  /// y -= A x
  static void subtract(const Tile& A, const S* x, S* y) {
    for (int c = 0; c < width; ++c) {
      for (int r = 0; r < width; ++r) y[r] -= A(r, c) * x[c];
    }
  }
  /// y -= A^T x
  static void subtract_transposed(const Tile& A, const S* x, S* y) {
    for (int c = 0; c < width; ++c) {
      for (int r = 0; r < width; ++r) y[c] -= A(r, c) * x[r];
    }
  }
  /// Column c of T less those before it times row c of L.
  static void subtract_columns(const Tile& L, int c, Tile& T) {
    for (int k = 0; k < c; ++k) {
      for (int r = 0; r < width; ++r) T(r, c) -= L(c, k) * T(r, k);
    }
  }
  /// T <- T L^-T
  static void divide(Tile& T, const Tile& L, const S* inverse_diagonal) {
    for (int c = 0; c < width; ++c) {
      subtract_columns(L, c, T);
      for (int r = 0; r < width; ++r) T(r, c) *= inverse_diagonal[c];
    }
  }
  /// T <- its factor. A pivot that is rounding of the diagonal it came from, that of `original`, does not count.
  bool factorize(Tile& T, const Tile& original, S* inverse_diagonal) const {
    const S tolerance = S(dim_) * std::numeric_limits<S>::epsilon();
    for (int c = 0; c < width; ++c) {
      subtract_columns(T, c, T);
      const S pivot = T(c, c);
      if (!(pivot > tolerance * original(c, c)) || !(pivot <= std::numeric_limits<S>::max())) return false;
      inverse_diagonal[c] = S(1) / std::sqrt(pivot);
      for (int r = 0; r < width; ++r) T(r, c) *= inverse_diagonal[c];
    }
    return true;
  }
  void forward(Padded& y, int first) const {
    for (int i = first; i < tiles(); ++i) {
      S* const y_i = y.data() + i * width;
      for (int k = first_[i] > first ? first_[i] : first; k < i; ++k) subtract(at(i, k), y.data() + k * width, y_i);
      const Tile& L = at(i, i);
      for (int c = 0; c < width; ++c) {
        y_i[c] *= inverse_diagonal_[i * width + c];
        for (int k = c + 1; k < width; ++k) y_i[k] -= L(k, c) * y_i[c];
      }
    }
  }

  int dim_ = 0;
  std::array<int, max_tiles> first_;                                      ///< block column where a row of L starts
  std::array<Tile, std::size_t(max_tiles) * (max_tiles + 1) / 2> tiles_;  ///< lower triangle, row by row
  Padded inverse_diagonal_;
};

}  // namespace plumbline
