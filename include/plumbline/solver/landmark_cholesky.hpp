#pragma once
/// Elimination of ONE landmark of few parameters from normal equations.      docs/math/local_bundle_adjustment.md
/// (8)-(11)
///
///   L L^T = H_ll + mu D_l,   c = L^-1 b_l,   Y_k = W_k L^-T                                                   (8)
///   H_ij -= Y_i Y_j^T,   b_i -= Y_i c                                                                        (9)
///   d_l = -L^-T (c + L^-1 sum_k W_k^T d_k)                                                                  (10)
///   predicted decrease = 1/2 (|c|^2 + mu d_l.D d_l)                                                         (11)
/// Beside landmark_elimination.hpp, which keeps rows and factorizes them by reflections (QR): here rows are summed to
/// products in A, double in practice, and forgotten. That costs half the digits of a landmark that is barely
/// determined, which the damping covers, and a fraction of the time and memory.

#include <array>
#include <cmath>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/block_cholesky.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class A, int Dim>
class LandmarkCholesky {
 public:
  using Block = Mat<A, Dim, Dim>;
  using Vector = Vec<A, Dim>;

  /// (8); reads the lower triangle. False where it is not positive definite, or not finite.
  bool factorize(const Block& H, const Vector& b, A mu) {
    L_ = H;
    Vector original;
    for (int k = 0; k < Dim; ++k) {
      damping_[k] = mu * damping_scale(H(k, k));
      L_(k, k) += damping_[k];
      original[k] = L_(k, k);
    }
    if (!factorize_block(L_, original)) return false;
    for (int k = 0; k < Dim; ++k) inverse_diagonal_[k] = A(1) / L_(k, k);
    c_ = b;
    solve_lower(L_, c_);
    return all_finite(c_);
  }
  /// W <- Y of (8), column by column.
  template <int N>
  void divide(std::array<Vec<A, N>, std::size_t(Dim)>& W) const {
    for (int c = 0; c < Dim; ++c) {
      for (int k = 0; k < c; ++k) W[std::size_t(c)] -= L_(c, k) * W[std::size_t(k)];
      W[std::size_t(c)] *= inverse_diagonal_[c];
    }
  }
  /// Y c
  template <int N>
  Vec<A, N> times_c(const std::array<Vec<A, N>, std::size_t(Dim)>& Y) const {
    Vec<A, N> out = c_[0] * Y[0];
    for (int k = 1; k < Dim; ++k) out += c_[k] * Y[std::size_t(k)];
    return out;
  }
  /// (10), of sum_k W_k^T d_k.
  Vector step(const Vector& W_d) const {
    Vector y = W_d;
    solve_lower(L_, y);
    return step_divided(y);
  }
  /// (10), of sum_k Y_k^T d_k.
  Vector step_divided(const Vector& Y_d) const {
    Vector y = c_ + Y_d;
    solve_upper(L_, y);
    return -y;
  }
  /// (11)
  A predicted_decrease(const Vector& d) const {
    A sum = squared_norm(c_);
    for (int k = 0; k < Dim; ++k) sum += damping_[k] * d[k] * d[k];
    return sum / 2;
  }

 private:
  Block L_;
  Vector c_, damping_, inverse_diagonal_;
};

}  // namespace plumbline
