#pragma once
/// Cholesky factor A = L L^T of a symmetric positive definite matrix of at most MaxDim rows, without heap.
///
///   L_ij L_jj^T = A_ij - sum_k L_ik L_jk^T,   k from the first block that rows i and j both have              (9)
/// in blocks of 4 x 4, row by row, docs/math/solver.md. A row of L starts where the row of A does: the part before
/// its first number that is not zero stays zero, and costs nothing. An order of the parameters that makes rows short
/// makes the factor cheap.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <class S, int MaxDim>
class Cholesky {
 public:
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, MaxDim, 1>;

  /// Factor of P (A + diag(damping)) P^T; reads the lower triangle of A (dim x dim), a matrix in memory. Row k of the
  /// factor belongs to parameter order(k). False when A is not positive definite to the precision of S, or not finite.
  template <class DA, class Dd, class Order>
  bool compute(const Eigen::MatrixBase<DA>& A, const Eigen::MatrixBase<Dd>& damping, Order&& order) {
    static_assert(int(DA::Flags) & Eigen::DirectAccessBit, "evaluate the expression first: it is read by element");
    PLUMBLINE_ASSERT(A.rows() <= MaxDim && A.cols() == A.rows() && damping.size() == A.rows());
    dim_ = int(A.rows());
    std::array<int, std::size_t(max_tiles) * width> parameters;
    for (int k = 0; k < dim_; ++k) parameters[k] = order(k);
    for (int i = 0; i < tiles(); ++i) {
      int first = i;
      for (int j = i; j >= 0; --j) {
        if (read(A.derived(), damping.derived(), parameters.data(), i, j, at(i, j))) first = j;
      }
      first_[i] = first;
      S* const inverse_diagonal = inverse_diagonal_.data();
      for (int j = first; j < i; ++j) {
        subtract_products(i, j, at(i, j));
        divide(at(i, j), at(j, j), inverse_diagonal + j * width);
      }
      Part original;
      for (int c = 0; c < width; ++c) original[c] = at(i, i)[c][c];
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
      const Tile& L = at(i, i);
      for (int c = width - 1; c >= 0; --c) {
        for (int k = c + 1; k < width; ++k) y[i][c] -= L[c][k] * y[i][k];
        y[i][c] *= inverse_diagonal_[i * width + c];
      }
      for (int k = first_[i]; k < i; ++k) {
        const Tile& A = at(i, k);
        for (int c = 0; c < width; ++c) y[k][c] -= dot(A[c], y[i]);
      }
    }
    for (int k = 0; k < dim_; ++k) x[k] = y[k / width][k % width];
  }

  /// x <- L^-1 x, where the numbers of x before `first` are zero.
  template <class D>
  void forward_in_place(Eigen::MatrixBase<D>& x, int first) const {
    Padded y = padded(x);
    forward(y, first / width);
    for (int k = 0; k < dim_; ++k) x[k] = y[k / width][k % width];
  }

 private:
  static constexpr int width = 4, max_tiles = (MaxDim + width - 1) / width;
  using Part = Vec<S, width>;
  using Tile = std::array<Part, width>;  // one block, column by column
  using Padded = std::array<Part, max_tiles>;

  int tiles() const { return (dim_ + width - 1) / width; }
  Tile& at(int i, int j) { return tiles_[std::size_t(i * (i + 1) / 2 + j)]; }
  const Tile& at(int i, int j) const { return tiles_[std::size_t(i * (i + 1) / 2 + j)]; }

  template <class D>
  Padded padded(const Eigen::MatrixBase<D>& x) const {
    Padded y;
    for (int k = 0; k < tiles() * width; ++k) y[k / width][k % width] = k < dim_ ? x[k] : S(0);
    return y;
  }

  /// Block (i, j) of the matrix, the identity beyond its end. False when it is zero.
  template <class DA, class Dd>
  bool read(const DA& A, const Dd& damping, const int* parameters, int i, int j, Tile& out) const {
    const int *const row = parameters + i * width, *const column = parameters + j * width;
    const int rows = std::min(width, dim_ - i * width), columns = std::min(width, dim_ - j * width);
    S sum = S(0);
    for (int c = 0; c < columns; ++c) {
      for (int r = 0; r < rows; ++r) {
        out[c][r] = A.coeff(std::max(row[r], column[c]), std::min(row[r], column[c]));
        sum += std::abs(out[c][r]);
      }
      for (int r = rows; r < width; ++r) out[c][r] = S(0);
      if (i == j) out[c][c] += damping[column[c]];
    }
    for (int c = columns; c < width; ++c) {
      for (int r = 0; r < width; ++r) out[c][r] = S(r == c);
    }
    return i == j || !(sum == S(0));  // true for NaN
  }

  /// T -= sum_k L_ik L_jk^T, k < j
  void subtract_products(int i, int j, Tile& T) const {
    Tile sum;  // column by column: GCC 12 takes a copy of the whole for one beyond its end
    for (int c = 0; c < width; ++c) sum[c] = T[c];
    for (int k = first_[i] > first_[j] ? first_[i] : first_[j]; k < j; ++k) {
      const Tile &A = at(i, k), &B = at(j, k);
      for (int c = 0; c < width; ++c) {
        for (int n = 0; n < width; ++n) sum[c] -= B[n][c] * A[n];
      }
    }
    for (int c = 0; c < width; ++c) T[c] = sum[c];
  }
  /// T <- T L^-T
  static void divide(Tile& T, const Tile& L, const S* inverse_diagonal) {
    for (int c = 0; c < width; ++c) {
      for (int k = 0; k < c; ++k) T[c] -= L[k][c] * T[k];
      T[c] *= inverse_diagonal[c];
    }
  }
  /// T <- its factor. A pivot that is rounding of the diagonal that it came from, `original`, does not count.
  bool factorize(Tile& T, const Part& original, S* inverse_diagonal) const {
    const S tolerance = S(dim_) * std::numeric_limits<S>::epsilon();
    for (int c = 0; c < width; ++c) {
      for (int k = 0; k < c; ++k) T[c] -= T[k][c] * T[k];
      const S pivot = T[c][c];
      if (!(pivot > tolerance * original[c]) || !(pivot <= std::numeric_limits<S>::max())) return false;
      inverse_diagonal[c] = S(1) / std::sqrt(pivot);
      T[c] *= inverse_diagonal[c];
    }
    return true;
  }
  void forward(Padded& y, int first) const {
    for (int i = first; i < tiles(); ++i) {
      for (int k = first_[i] > first ? first_[i] : first; k < i; ++k) {
        const Tile& A = at(i, k);
        for (int c = 0; c < width; ++c) y[i] -= y[k][c] * A[c];
      }
      const Tile& L = at(i, i);
      for (int c = 0; c < width; ++c) {
        y[i][c] *= inverse_diagonal_[i * width + c];
        for (int k = c + 1; k < width; ++k) y[i][k] -= L[c][k] * y[i][c];
      }
    }
  }

  int dim_ = 0;
  std::array<int, max_tiles> first_;                                      ///< block column where a row of L starts
  std::array<Tile, std::size_t(max_tiles) * (max_tiles + 1) / 2> tiles_;  ///< lower triangle, row by row
  std::array<S, std::size_t(max_tiles) * width> inverse_diagonal_;
};

}  // namespace plumbline
