#pragma once
/// Dense symmetric system over MaxBlocks parameter blocks of BlockDim rows:  H d = -b.     docs/math/solver.md (6)-(8)
///
///   H = sum w J^T J,  b = sum w J^T r,  cost = 1/2 sum rho                                                    (6)
///   (H + mu clip(diag H, 1e-6, 1e6)) d = -b                                                                   (7)
///   predicted decrease = -d.b - 1/2 d.H d = 1/2 (mu d.D d - d.b)  of the step (7), D the clipped diagonal     (8)
/// J and r are whitened; w = rho' of the robust kernel. Of H only the LOWER triangle holds values: blocks (i, j), i >
/// j, and the diagonal blocks. S is double in practice, even when the Jacobians are float.
///
/// A Jacobian may have fewer than BlockDim columns: it then belongs to the LEADING parameters of its block (a camera
/// sees the pose of a block [pose, velocity, biases]).

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/bounded_matrix.hpp"
#include "plumbline/solver/cholesky.hpp"

namespace plumbline {

/// D of (7).
template <class S>
constexpr S damping_scale(S diagonal) {
  return std::clamp(diagonal, S(1e-6), S(1e6));
}

template <class S, int BlockDim, int MaxBlocks>
class NormalEquations {
 public:
  using Scalar = S;
  static constexpr int block_dim = BlockDim, max_blocks = MaxBlocks, max_dim = BlockDim * MaxBlocks;
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, max_dim, 1>;

  /// Zero, for `blocks` active blocks.
  void reset(int blocks) {
    PLUMBLINE_ASSERT(blocks >= 0 && blocks <= MaxBlocks);
    blocks_ = blocks;
    H_.resize(dim(), dim());
    H_.setZero();
    b_.setZero(dim());
    sum_rho_ = S(0);
  }

  int blocks() const { return blocks_; }
  int dim() const { return blocks_ * BlockDim; }
  /// 1/2 sum rho over all that was given to `add_cost`; adding rows does not change it.
  S cost() const { return sum_rho_ / 2; }
  void add_cost(S rho) { sum_rho_ += rho; }

  /// Rows that touch block i.
  template <class T, int R, int C>
  void add(int i, const Mat<T, R, C>& J_i, const Vec<T, R>& r, S weight) {
    const Rows<R, C> a(J_i);
    const Rows<R, 1> e(r);
    add_product<C, C>(i, a.data, i, a.data, R, C, weight);
    add_gradient<C>(i, a.data, e.data, R, C, weight);
  }
  /// Rows that touch blocks i and j, i != j.
  template <class T, int R, int C, int D>
  void add(int i, const Mat<T, R, C>& J_i, int j, const Mat<T, R, D>& J_j, const Vec<T, R>& r, S weight) {
    PLUMBLINE_ASSERT(i != j);
    constexpr int stride = C + D;
    const Rows<R, stride> ab(J_i, J_j);
    const Rows<R, 1> e(r);
    const S *a = ab.data, *b = ab.data + C;
    add_product<C, C>(i, a, i, a, R, stride, weight);
    add_product<D, D>(j, b, j, b, R, stride, weight);
    if (i > j) {
      add_product<C, D>(i, a, j, b, R, stride, weight);
    } else {
      add_product<D, C>(j, b, i, a, R, stride, weight);
    }
    add_gradient<C>(i, a, e.data, R, stride, weight);
    add_gradient<D>(j, b, e.data, R, stride, weight);
  }

  /// H_ij += weight sum_k a_k b_k^T, i >= j, for rows a_k (C numbers) and b_k (D numbers) that are `stride` apart.
  template <int C, int D>
  void add_product(int i, const S* a, int j, const S* b, int rows, int stride, S weight) {
    static_assert(C <= BlockDim && D <= BlockDim, "plumbline: a Jacobian has more columns than a parameter block");
    PLUMBLINE_ASSERT(i >= j && j >= 0 && i < blocks_);
    const int dim = this->dim();
    S* const block = H_.data() + j * BlockDim * dim + i * BlockDim;
    const auto column = [&](int d) { return Eigen::Map<Vec<S, C>>(block + d * dim); };
    const auto row = [&](int k) { return Eigen::Map<const Vec<S, C>>(a + k * stride); };
    const auto scale = [&](int k, int d) { return weight * b[k * stride + d]; };
    int k = 0;
    for (; k + 3 <= rows; k += 3) {  // three rows at a time: H is read and written once for them
      for (int d = 0; d < D; ++d) {
        column(d) += scale(k, d) * row(k) + scale(k + 1, d) * row(k + 1) + scale(k + 2, d) * row(k + 2);
      }
    }
    for (; k + 2 <= rows; k += 2) {
      for (int d = 0; d < D; ++d) column(d) += scale(k, d) * row(k) + scale(k + 1, d) * row(k + 1);
    }
    if (k < rows) {
      for (int d = 0; d < D; ++d) column(d) += scale(k, d) * row(k);
    }
  }
  /// b_i += weight sum_k a_k r_k.
  template <int C>
  void add_gradient(int i, const S* a, const S* r, int rows, int stride, S weight) {
    Eigen::Map<Vec<S, C>> segment(b_.data() + i * BlockDim);
    for (int k = 0; k < rows; ++k) segment += (weight * r[k]) * Eigen::Map<const Vec<S, C>>(a + k * stride);
  }

  /// Dense rows (a prior) r = r0 + J0 e over the leading J0.cols() columns: H += J0^T J0, b += J0^T r.
  /// Zeros at the bottom of a column (an upper triangular J0) are not multiplied.
  template <class DJ, class Dr, class De>
  void add_dense(const Eigen::MatrixBase<DJ>& J0, const Eigen::MatrixBase<Dr>& r0, const Eigen::MatrixBase<De>& e) {
    PLUMBLINE_ASSERT(J0.cols() <= dim() && J0.rows() == r0.size() && J0.cols() == e.size());
    const int columns = int(J0.cols());
    Eigen::Matrix<S, Eigen::Dynamic, 1, 0, DJ::MaxRowsAtCompileTime, 1> r = r0.template cast<S>();
    for (int j = 0; j < columns; ++j) r += S(e[j]) * J0.col(j).template cast<S>();
    for (int j = 0; j < columns; ++j) {
      int rows = int(J0.rows());
      while (rows > 0 && J0(rows - 1, j) == 0) --rows;
      b_[j] += J0.col(j).head(rows).template cast<S>().dot(r.head(rows));
      for (int i = j; i < columns; ++i) {
        H_(i, j) += J0.col(i).head(rows).template cast<S>().dot(J0.col(j).head(rows).template cast<S>());
      }
    }
  }
  template <class DJ, class Dr>
  void add_dense(const Eigen::MatrixBase<DJ>& J0, const Eigen::MatrixBase<Dr>& r0) {
    add_dense(J0, r0, Vector::Zero(J0.cols()));
  }

  /// The step (7). False, and d undefined, when the damped H is not positive definite or anything is not finite.
  bool solve(S mu, Vector& d) const {
    if (!factor_.compute(H_, mu * scale())) return false;
    d = -b_;
    factor_.solve_in_place(d);
    return d.allFinite();
  }

  /// (8), for the step d that `solve` gave with the same mu.
  S predicted_decrease(S mu, const Vector& d) const {
    return (mu * scale().cwiseProduct(d.cwiseAbs2()).sum() - d.dot(b_)) / 2;
  }

  /// Block (i, i) of H^-1: the covariance of parameter block i. False when H is singular.
  bool covariance_block(int i, Mat<S, BlockDim, BlockDim>& covariance) const {
    if (!factor_.compute(H_, Vector::Zero(dim()))) return false;
    for (int k = 0; k < BlockDim; ++k) {
      Vector column = Vector::Unit(dim(), i * BlockDim + k);
      factor_.solve_in_place(column);
      covariance.col(k) = column.template segment<BlockDim>(i * BlockDim);
    }
    return covariance.allFinite();
  }

  const auto& H() const { return H_; }
  const Vector& b() const { return b_; }

 private:
  /// Jacobians side by side, one row after the other.
  template <int R, int C>
  struct Rows {
    S data[R * C];
    template <class... J>
    explicit Rows(const J&... jacobians) {
      int column = 0;
      (write(jacobians, column), ...);
    }

   private:
    template <class T, int D>
    void write(const Mat<T, R, D>& J, int& column) {
      for (int d = 0; d < D; ++d, ++column) {
        for (int k = 0; k < R; ++k) data[k * C + column] = S(J(k, d));
      }
    }
  };

  Vector scale() const {
    return H_.diagonal().unaryExpr([](S x) { return damping_scale(x); });
  }

  int blocks_ = 0;
  S sum_rho_ = S(0);
  BoundedMatrix<S, max_dim, max_dim> H_;
  Vector b_;
  mutable Cholesky<S, max_dim> factor_;  // scratch: too large for the stack
};

}  // namespace plumbline
