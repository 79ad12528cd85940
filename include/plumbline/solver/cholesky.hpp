#pragma once
/// Cholesky factor A = U^T U of a symmetric positive definite matrix of at most MaxDim rows, without heap.
///
///   U_jj^2 = A_jj - |U_0j|^2,   U_ij = (A_ij - U_0i . U_0j) / U_ii   (columns above the diagonal) docs/math/solver.md
///   (9)
/// Left-looking by columns: each number is one dot product of contiguous memory.

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "plumbline/solver/bounded_matrix.hpp"

namespace plumbline {

template <class S, int MaxDim>
class Cholesky {
 public:
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, MaxDim, 1>;

  /// Factor of A + diag(damping); reads the lower triangle of A (dim x dim). False when A is not positive definite to
  /// the precision of S, or not finite.
  template <class DA, class Dd>
  bool compute(const Eigen::MatrixBase<DA>& A, const Eigen::MatrixBase<Dd>& damping) {
    const int dim = int(A.rows());
    const S tolerance = S(dim) * std::numeric_limits<S>::epsilon();
    U_.resize(dim, dim);
    inverse_diagonal_.resize(dim);
    for (int j = 0; j < dim; ++j) {
      for (int i = 0; i < j; ++i) {
        U_(i, j) = (A(j, i) - U_.col(i).head(i).dot(U_.col(j).head(i))) * inverse_diagonal_[i];
      }
      const S diagonal = A(j, j) + damping[j], pivot = diagonal - U_.col(j).head(j).squaredNorm();
      if (!(pivot > tolerance * diagonal) || !(pivot <= std::numeric_limits<S>::max())) return false;
      U_(j, j) = std::sqrt(pivot);
      inverse_diagonal_[j] = S(1) / U_(j, j);
    }
    return true;
  }

  /// x <- A^-1 x, after compute.
  template <class D>
  void solve_in_place(Eigen::MatrixBase<D>& x) const {
    const int dim = int(U_.rows());
    for (int j = 0; j < dim; ++j) x[j] = (x[j] - U_.col(j).head(j).dot(x.head(j))) * inverse_diagonal_[j];
    for (int j = dim - 1; j >= 0; --j) {
      x[j] *= inverse_diagonal_[j];
      x.head(j) -= x[j] * U_.col(j).head(j);
    }
  }

 private:
  BoundedMatrix<S, MaxDim, MaxDim> U_;
  Vector inverse_diagonal_;
};

}  // namespace plumbline
