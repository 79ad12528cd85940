#pragma once
/// Eigenvalues and eigenvectors of a small symmetric matrix by cyclic Jacobi rotations.     docs/math/solver.md (19)
///
///   A = V diag(values) V^T,   values descending, V orthonormal (its determinant may be -1)
///   tan t of the rotation that clears A_pq:  sign(h) / (|h| + sqrt(h^2 + 1)),  h = (A_qq - A_pp) / (2 A_pq)
/// The work is bounded: convergence is quadratic, and 3 x 3 to 9 x 9 need four to six sweeps.

#include <cmath>
#include <concepts>
#include <limits>
#include <utility>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S, int N>
struct SymmetricEigen {
  static constexpr int max_sweeps = 12;

  bool valid = false;  ///< false for numbers that are not finite
  Vec<S, N> values;    ///< descending
  Mat<S, N, N> V;      ///< its columns belong to `values`

  explicit SymmetricEigen(Mat<S, N, N> A) {
    for (int j = 0; j < N; ++j) {
      for (int i = 0; i < N; ++i) V(i, j) = S(i == j);
    }
    valid = all_finite(A);
    for (int sweep = 0; valid && sweep < max_sweeps; ++sweep) {
      S off = 0, diagonal = 0;
      for (int p = 0; p < N; ++p) {
        diagonal += A(p, p) * A(p, p);
        for (int q = p + 1; q < N; ++q) off += A(p, q) * A(p, q);
      }
      constexpr S epsilon = std::numeric_limits<S>::epsilon();
      if (!(off > epsilon * epsilon * diagonal)) break;
      for (int p = 0; p < N; ++p) {
        for (int q = p + 1; q < N; ++q) clear(A, p, q);
      }
    }
    for (int k = 0; k < N; ++k) values[k] = A(k, k);
    for (int k = 0; k < N; ++k) {
      int largest = k;
      for (int m = k + 1; m < N; ++m) largest = values[m] > values[largest] ? m : largest;
      std::swap(values[k], values[largest]);
      for (int i = 0; i < N; ++i) std::swap(V(i, k), V(i, largest));
    }
  }

  Vec<S, N> vector(int k) const { return block<N, 1>(V, 0, k); }

 private:
  void clear(Mat<S, N, N>& A, int p, int q) {
    if (A(p, q) == S(0)) return;
    const S h = (A(q, q) - A(p, p)) / (2 * A(p, q));
    const S t = std::copysign(S(1), h) / (std::abs(h) + std::sqrt(h * h + S(1)));  // 0 where h overflows
    const S c = S(1) / std::sqrt(t * t + S(1)), s = t * c;
    const auto rotate = [c, s](S& x, S& y) {
      const S x_new = c * x - s * y;
      y = s * x + c * y;
      x = x_new;
    };
    for (int k = 0; k < N; ++k) rotate(A(k, p), A(k, q));
    for (int k = 0; k < N; ++k) rotate(A(p, k), A(q, k));
    for (int k = 0; k < N; ++k) rotate(V(k, p), V(k, q));
    A(p, q) = A(q, p) = S(0);
  }
};

}  // namespace plumbline
