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
    const Mat<S, R, C> J = J_i.template cast<S>();
    const Mat<S, C, R> wJt = weight * J.transpose();  // by columns, so that the products below run along columns of H
    add_block(i, i, wJt, J);
    b_.template segment<C>(i * BlockDim).noalias() += wJt * r.template cast<S>();
  }
  /// Rows that touch blocks i and j, i != j.
  template <class T, int R, int C, int D>
  void add(int i, const Mat<T, R, C>& J_i, int j, const Mat<T, R, D>& J_j, const Vec<T, R>& r, S weight) {
    PLUMBLINE_ASSERT(i != j);
    add(i, J_i, r, weight);
    add(j, J_j, r, weight);
    if (i > j) {
      add_product(i, J_i, j, J_j, weight);
    } else {
      add_product(j, J_j, i, J_i, weight);
    }
  }

  /// H_ij += weight J_i^T J_j, i >= j.
  template <class T, int R, int C, int D>
  void add_product(int i, const Mat<T, R, C>& J_i, int j, const Mat<T, R, D>& J_j, S weight) {
    const Mat<S, C, R> wJt = weight * J_i.transpose().template cast<S>();
    add_block(i, j, wJt, Mat<S, R, D>(J_j.template cast<S>()));
  }

  /// Dense rows (a prior) r = r0 + J0 e over the leading J0.cols() columns, whole blocks: H += J0^T J0, b += J0^T r.
  /// Zeros at the bottom of columns (an upper triangular J0) are not multiplied.
  template <class DJ, class Dr, class De>
  void add_dense(const Eigen::MatrixBase<DJ>& J0, const Eigen::MatrixBase<Dr>& r0, const Eigen::MatrixBase<De>& e) {
    PLUMBLINE_ASSERT(J0.cols() <= dim() && J0.cols() % BlockDim == 0 && J0.rows() == r0.size());
    const int blocks = int(J0.cols()) / BlockDim;
    Eigen::Matrix<S, Eigen::Dynamic, 1, 0, DJ::MaxRowsAtCompileTime, 1> r = r0.template cast<S>();
    for (int k = 0; k < J0.cols(); ++k) r += S(e[k]) * J0.col(k).template cast<S>();
    for (int j = 0; j < blocks; ++j) {
      const int begin = j * BlockDim;
      int rows = int(J0.rows());
      while (rows > 0 && (J0.row(rows - 1).template segment<BlockDim>(begin).array() == 0).all()) --rows;
      b_.template segment<BlockDim>(begin) +=
          J0.template middleCols<BlockDim>(begin).template cast<S>().transpose().lazyProduct(r);
      for (int i = j; i < blocks; ++i) {
        H_.template block<BlockDim, BlockDim>(i * BlockDim, begin) +=
            J0.template middleCols<BlockDim>(i * BlockDim)
                .topRows(rows)
                .template cast<S>()
                .transpose()
                .lazyProduct(J0.template middleCols<BlockDim>(begin).topRows(rows).template cast<S>());
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
  template <int C, int R, int D>
  void add_block(int i, int j, const Mat<S, C, R>& wJt, const Mat<S, R, D>& J) {
    static_assert(C <= BlockDim && D <= BlockDim, "plumbline: a Jacobian has more columns than a parameter block");
    PLUMBLINE_ASSERT(i >= j && j >= 0 && i < blocks_);
    H_.template block<C, D>(i * BlockDim, j * BlockDim).noalias() += wJt * J;
  }

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
