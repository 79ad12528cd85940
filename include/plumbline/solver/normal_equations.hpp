#pragma once
/// Dense symmetric system over MaxBlocks parameter blocks of BlockDim rows:  H d = -b.     docs/math/solver.md (6)-(8)
///
///   H = sum w J^T J,  b = sum w J^T r,  cost = 1/2 sum rho                                                    (6)
///   (H + mu clip(diag H, 1e-6, 1e6)) d = -b                                                                   (7)
///   predicted decrease = -d.b - 1/2 d.H d = 1/2 (mu d.D d - d.b)  of the step (7), D the clipped diagonal     (8)
/// J and r are whitened; w = rho' of the robust kernel. Of H only the LOWER triangle holds values: the diagonal blocks
/// and blocks (i, j), i > j. S is double in practice, even when the Jacobians are float.
///
/// A Jacobian may have fewer than BlockDim columns: it then belongs to the LEADING parameters of its block (a camera
/// sees the pose of a block [pose, velocity, biases]).
///
/// The step does not depend on the order in which parameters are eliminated, its cost does: see Cholesky.

#include <algorithm>
#include <array>
#include <cstdint>

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
  using Order = std::array<std::int16_t, std::size_t(max_dim)>;

  NormalEquations() {
    for (int k = 0; k < max_dim; ++k) order_[k] = std::int16_t(k);
  }

  /// Zero, for `blocks` active blocks.
  void reset(int blocks) {
    PLUMBLINE_ASSERT(blocks >= 0 && blocks <= MaxBlocks);
    blocks_ = blocks;
    H_.resize(dim(), dim());
    std::fill_n(H_.data(), dim() * dim(), S(0));
    b_.resize(dim());
    set_zero(b_);
    sum_rho_ = S(0);
  }
  /// The parameters in the order in which they are eliminated, the first dim() of them.
  void set_order(const Order& order) { order_ = order; }

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
    add_product<R, C, C>(i, a.data, i, a.data, C, weight);
    add_gradient<R, C>(i, a.data, e.data, C, weight);
  }
  /// Rows that touch blocks i and j, i != j.
  template <class T, int R, int C, int D>
  void add(int i, const Mat<T, R, C>& J_i, int j, const Mat<T, R, D>& J_j, const Vec<T, R>& r, S weight) {
    PLUMBLINE_ASSERT(i != j);
    constexpr int stride = C + D;
    const Rows<R, stride> ab(J_i, J_j);
    const Rows<R, 1> e(r);
    const S *a = ab.data, *b = ab.data + C;
    add_product<R, C, C>(i, a, i, a, stride, weight);
    add_product<R, D, D>(j, b, j, b, stride, weight);
    if (i > j) {
      add_product<R, C, D>(i, a, j, b, stride, weight);
    } else {
      add_product<R, D, C>(j, b, i, a, stride, weight);
    }
    add_gradient<R, C>(i, a, e.data, stride, weight);
    add_gradient<R, D>(j, b, e.data, stride, weight);
  }

  /// H += what is known otherwise of the leading parameters; its lower triangle is read.
  template <class DH>
  void add(const Eigen::MatrixBase<DH>& H) {
    PLUMBLINE_ASSERT(H.rows() == H.cols() && H.cols() <= dim());
    for (int j = 0; j < int(H.cols()); ++j) {
      for (int i = j; i < int(H.cols()); ++i) H_(i, j) += H(i, j);
    }
  }

  /// H_ij += B, i >= j.
  template <class D>
  void add_block(int i, int j, const Eigen::MatrixBase<D>& B) {
    static_assert(D::RowsAtCompileTime <= BlockDim && D::ColsAtCompileTime <= BlockDim);
    S* const block = block_at(i, j);
    for (int c = 0; c < D::ColsAtCompileTime; ++c) {
      for (int r = 0; r < D::RowsAtCompileTime; ++r) block[c * dim() + r] += B(r, c);
    }
  }
  /// b_i += g.
  template <int C>
  void add_gradient(int i, const Vec<S, C>& g) {
    for (int c = 0; c < C; ++c) b_[i * BlockDim + c] += g[c];
  }
  /// b += g, of the leading parameters.
  template <class D>
  void add_gradient(const Eigen::MatrixBase<D>& g) {
    PLUMBLINE_ASSERT(g.size() <= dim());
    for (int k = 0; k < int(g.size()); ++k) b_[k] += g[k];
  }

  /// H_ij -= sum_k a_k b_k^T, i >= j, for few rows.
  template <std::size_t R, int C>
  void subtract_product(int i, const std::array<Vec<S, C>, R>& a, int j, const std::array<Vec<S, C>, R>& b) {
    add_products(i, a, j, b, [](auto& out, const Vec<S, C>& sum) { out -= sum; });
  }
  /// The same with the other sign.
  template <std::size_t R, int C>
  void add_product(int i, const std::array<Vec<S, C>, R>& a, int j, const std::array<Vec<S, C>, R>& b) {
    add_products(i, a, j, b, [](auto& out, const Vec<S, C>& sum) { out += sum; });
  }

  /// The step (7). False, and d undefined, when the damped H is not positive definite or anything is not finite.
  bool solve(S mu, Vector& d) const { return solve(mu, b_, d); }
  /// The same of another b.
  bool solve(S mu, const Vector& b, Vector& d) const {
    if (!factorize(mu)) return false;
    Vector x(dim());
    for (int k = 0; k < dim(); ++k) x[k] = -b[order_[k]];
    factor_.solve_in_place(x);
    d.resize(dim());
    for (int k = 0; k < dim(); ++k) d[order_[k]] = x[k];
    return all_finite(d);
  }

  /// (8), for the step d that `solve` gave with the same mu.
  S predicted_decrease(S mu, const Vector& d) const {
    S sum = S(0);
    for (int k = 0; k < dim(); ++k) sum += (mu * damping_scale(H_(k, k)) * d[k] - b_[k]) * d[k];
    return sum / 2;
  }

  /// Covariance of the leading C parameters of block i: their part of H^-1. False when H is singular.
  template <int C>
  bool covariance_block(int i, Mat<S, C, C>& covariance) const {
    return joint_covariance(std::array<int, 1>{i}, covariance);
  }
  /// The joint covariance of the leading parameters of several blocks.
  template <std::size_t N, int Dim>
  bool joint_covariance(const std::array<int, N>& blocks, Mat<S, Dim, Dim>& covariance) const {
    constexpr int C = Dim / int(N);
    static_assert(C <= BlockDim && C * int(N) == Dim);
    if (!factorize(S(0))) return false;
    std::array<Vector, std::size_t(Dim)> Y;  // columns of L^-1 E, the covariance is Y^T Y
    for (int k = 0; k < dim(); ++k) {
      for (int n = 0; n < int(N); ++n) {
        const int c = order_[k] - blocks[std::size_t(n)] * BlockDim;
        if (c < 0 || c >= C) continue;
        Vector& y = Y[std::size_t(n * C + c)];
        y.resize(dim());
        set_zero(y);
        y[k] = S(1);
        factor_.forward_in_place(y, k);
      }
    }
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c <= r; ++c) covariance(r, c) = covariance(c, r) = Y[std::size_t(r)].dot(Y[std::size_t(c)]);
    }
    return all_finite(covariance);
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

  /// The lower triangle of H from block (i, j) on, its columns dim() apart.
  S* block_at(int i, int j) {
    PLUMBLINE_ASSERT(i >= j && j >= 0 && i < blocks_);
    return H_.data() + j * BlockDim * dim() + i * BlockDim;
  }
  template <std::size_t R, int C>
  void add_products(int i, const std::array<Vec<S, C>, R>& a, int j, const std::array<Vec<S, C>, R>& b, auto&& write) {
    const int stride = dim();
    S* column = block_at(i, j);
    for (int d = 0; d < C; ++d, column += stride) {
      Vec<S, C> sum = b[0][d] * a[0];
      for (std::size_t k = 1; k < R; ++k) sum += b[k][d] * a[k];
      Eigen::Map<Vec<S, C>> out(column);
      write(out, sum);
    }
  }

  /// y += s x
  template <int C>
  static void add_scaled(S s, const S* x, S* y) {
    for (int c = 0; c < C; ++c) y[c] += s * x[c];
  }
  /// H_ij += weight sum_k a_k b_k^T, i >= j, for R rows a_k (C numbers) and b_k (D numbers) that are `stride` apart.
  template <int R, int C, int D>
  void add_product(int i, const S* a, int j, const S* b, int stride, S weight) {
    static_assert(C <= BlockDim && D <= BlockDim, "plumbline: a Jacobian has more columns than a parameter block");
    constexpr int in_threes = R - R % 3;  // three rows at a time: H is read and written once for them
    S* const block = block_at(i, j);
    for (int k = 0; k < in_threes; k += 3) {
      const S *a0 = a + k * stride, *a1 = a0 + stride, *a2 = a1 + stride;
      for (int d = 0; d < D; ++d) {
        const S* const b_d = b + k * stride + d;
        const S s0 = weight * b_d[0], s1 = weight * b_d[stride], s2 = weight * b_d[2 * stride];
        S* const column = block + d * dim();
        for (int c = 0; c < C; ++c) column[c] += s0 * a0[c] + s1 * a1[c] + s2 * a2[c];
      }
    }
    for (int k = in_threes; k < R; ++k) {
      for (int d = 0; d < D; ++d) add_scaled<C>(weight * b[k * stride + d], a + k * stride, block + d * dim());
    }
  }
  /// b_i += weight sum_k a_k r_k.
  template <int R, int C>
  void add_gradient(int i, const S* a, const S* r, int stride, S weight) {
    for (int k = 0; k < R; ++k) add_scaled<C>(weight * r[k], a + k * stride, b_.data() + i * BlockDim);
  }

  bool factorize(S mu) const {
    Vector damping(dim());
    for (int k = 0; k < dim(); ++k) damping[k] = mu * damping_scale(H_(k, k));
    return factor_.compute(H_, damping, [this](int k) { return int(order_[k]); });
  }

  int blocks_ = 0;
  S sum_rho_ = S(0);
  Order order_;
  BoundedMatrix<S, max_dim, max_dim> H_;
  Vector b_;
  mutable Cholesky<S, max_dim> factor_;  // scratch: too large for the stack
};

}  // namespace plumbline
