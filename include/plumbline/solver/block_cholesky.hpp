#pragma once
/// The steps of a Cholesky factor by blocks, each for small blocks of fixed size.   docs/math/pose_graph.md (15)-(18)
///
///   A = L L^T,   X <- X L^-T,   C -= A B^T,   y <- L^-1 y,   y <- L^-T y
/// L is lower triangular; what stands above its diagonal is not read. Loops run down the columns, so they vectorize.

#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// A <- L, reads the lower triangle. False when A is not finite, or when a pivot is rounding of the number `original`
/// that its diagonal had before anything was subtracted from it.
template <class S, int N>
bool factorize_block(Mat<S, N, N>& A, const Vec<S, N>& original) {
  constexpr S tolerance = S(N) * std::numeric_limits<S>::epsilon();
  for (int c = 0; c < N; ++c) {
    for (int k = 0; k < c; ++k) {
      const S factor = A.coeff(c, k);
      for (int r = c; r < N; ++r) A.coeffRef(r, c) -= A.coeff(r, k) * factor;
    }
    const S pivot = A.coeff(c, c);
    if (!(pivot > tolerance * original.coeff(c)) || !(pivot <= std::numeric_limits<S>::max())) return false;
    const S root = std::sqrt(pivot), inverse = S(1) / root;
    A.coeffRef(c, c) = root;
    for (int r = c + 1; r < N; ++r) A.coeffRef(r, c) *= inverse;
  }
  return true;
}

/// X <- X L^-T
template <class S, int R, int N>
void divide_block(Mat<S, R, N>& X, const Mat<S, N, N>& L) {
  for (int c = 0; c < N; ++c) {
    for (int k = 0; k < c; ++k) {
      const S factor = L.coeff(c, k);
      for (int r = 0; r < R; ++r) X.coeffRef(r, c) -= factor * X.coeff(r, k);
    }
    const S inverse = S(1) / L.coeff(c, c);
    for (int r = 0; r < R; ++r) X.coeffRef(r, c) *= inverse;
  }
}

/// C += w A^T B
template <class S, int R, int C, int K>
void add_transposed_product(Mat<S, R, C>& out, const Mat<S, K, R>& A, const Mat<S, K, C>& B, S weight) {
  S transposed[K][R];
  for (int r = 0; r < R; ++r) {
    for (int k = 0; k < K; ++k) transposed[k][r] = weight * A.coeff(k, r);
  }
  for (int c = 0; c < C; ++c) {
    S sum[R];
    for (int r = 0; r < R; ++r) sum[r] = out.coeff(r, c);
    for (int k = 0; k < K; ++k) {
      const S factor = B.coeff(k, c);
      for (int r = 0; r < R; ++r) sum[r] += factor * transposed[k][r];
    }
    for (int r = 0; r < R; ++r) out.coeffRef(r, c) = sum[r];
  }
}

/// C -= A B^T
template <class S, int R, int C, int K>
void subtract_product(Mat<S, R, C>& out, const Mat<S, R, K>& A, const Mat<S, C, K>& B) {
  for (int c = 0; c < C; ++c) {
    S sum[R];  // for all that a compiler knows A or B could be `out`
    for (int r = 0; r < R; ++r) sum[r] = out.coeff(r, c);
    for (int k = 0; k < K; ++k) {
      const S factor = B.coeff(c, k);
      for (int r = 0; r < R; ++r) sum[r] -= factor * A.coeff(r, k);
    }
    for (int r = 0; r < R; ++r) out.coeffRef(r, c) = sum[r];
  }
}

/// y -= A x
template <class S, int R, int C>
void subtract_product(Vec<S, R>& y, const Mat<S, R, C>& A, const Vec<S, C>& x) {
  for (int c = 0; c < C; ++c) {
    const S factor = x.coeff(c);
    for (int r = 0; r < R; ++r) y.coeffRef(r) -= A.coeff(r, c) * factor;
  }
}
/// y -= A^T x
template <class S, int R, int C>
void subtract_transposed_product(Vec<S, C>& y, const Mat<S, R, C>& A, const Vec<S, R>& x) {
  for (int c = 0; c < C; ++c) {
    S sum = S(0);
    for (int r = 0; r < R; ++r) sum += A.coeff(r, c) * x.coeff(r);
    y.coeffRef(c) -= sum;
  }
}

/// y <- L^-1 y
template <class S, int N>
void solve_lower(const Mat<S, N, N>& L, Vec<S, N>& y) {
  for (int c = 0; c < N; ++c) {
    y.coeffRef(c) /= L.coeff(c, c);
    for (int r = c + 1; r < N; ++r) y.coeffRef(r) -= L.coeff(r, c) * y.coeff(c);
  }
}
/// y <- L^-T y
template <class S, int N>
void solve_upper(const Mat<S, N, N>& L, Vec<S, N>& y) {
  for (int c = N - 1; c >= 0; --c) {
    for (int r = c + 1; r < N; ++r) y.coeffRef(c) -= L.coeff(r, c) * y.coeff(r);
    y.coeffRef(c) /= L.coeff(c, c);
  }
}

/// (L L^T)^-1
template <class S, int N>
Mat<S, N, N> inverse_of_factored(const Mat<S, N, N>& L) {
  Mat<S, N, N> out;
  for (int c = 0; c < N; ++c) {
    Vec<S, N> y = zeros<S, N>();
    y.coeffRef(c) = S(1);
    solve_lower(L, y);
    solve_upper(L, y);
    for (int r = 0; r < N; ++r) out.coeffRef(r, c) = y.coeff(r);
  }
  for (int c = 0; c < N; ++c) {
    for (int r = c + 1; r < N; ++r) out.coeffRef(r, c) = out.coeffRef(c, r) = (out(r, c) + out(c, r)) / 2;
  }
  return out;
}

}  // namespace plumbline
