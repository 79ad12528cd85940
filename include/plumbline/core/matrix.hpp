#pragma once
/// Matrices and vectors of fixed size, and what is done to them everywhere.

#include <Eigen/Core>
#include <cmath>

#include "plumbline/core/matrix_functions.hpp"
#include "plumbline/core/matrix_operators.hpp"
#include "plumbline/core/matrix_types.hpp"

namespace plumbline {

/// [a]x with hat(a) * b = a x b.                                                          docs/conventions.md
template <class Derived>
Mat<typename Derived::Scalar, 3, 3> hat(const Eigen::MatrixBase<Derived>& a) {
  EIGEN_STATIC_ASSERT_VECTOR_SPECIFIC_SIZE(Derived, 3)
  using S = typename Derived::Scalar;
  Mat<S, 3, 3> out;
  out << S(0), -a.z(), a.y(), a.z(), S(0), -a.x(), -a.y(), a.x(), S(0);
  return out;
}

/// True when no number is NaN or infinite.
template <class Derived>
bool all_finite(const Eigen::PlainObjectBase<Derived>& m) {
  for (int k = 0; k < int(m.size()); ++k) {
    if (!std::isfinite(m.data()[k])) return false;
  }
  return true;
}

// Parts and products as functions: each combination of sizes in a block or product expression of Eigen's is a few more
// classes to compile, and its larger products are not free of a heap. The sizes are fixed, so the loops unroll.

/// R x C numbers of A, the first of them A(i, j).
template <int R, int C, class S, int Rows, int Cols>
Mat<S, R, C> block(const Mat<S, Rows, Cols>& A, int i, int j) {
  Mat<S, R, C> out;
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) out.coeffRef(r, c) = A.coeff(i + r, j + c);
  }
  return out;
}
template <class S, int Rows, int Cols, int R, int C>
void set_block(Mat<S, Rows, Cols>& A, int i, int j, const Mat<S, R, C>& B) {
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) A.coeffRef(i + r, j + c) = B.coeff(r, c);
  }
}

/// N numbers of x, the first of them x[i].
template <int N, class S, int Size>
Vec<S, N> segment(const Vec<S, Size>& x, int i) {
  Vec<S, N> out;
  for (int k = 0; k < N; ++k) out.coeffRef(k) = x.coeff(i + k);
  return out;
}
template <class S, int Size, int N>
void set_segment(Vec<S, Size>& x, int i, const Vec<S, N>& y) {
  for (int k = 0; k < N; ++k) x.coeffRef(i + k) = y.coeff(k);
}

/// A B
template <class S, int R, int K, int C>
Mat<S, R, C> product(const Mat<S, R, K>& A, const Mat<S, K, C>& B) {
  // Not into the result at once: a compiler has to assume that it aliases A or B, and would not vectorize.
  S out[R * C];
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) {
      S sum = A.coeff(r, 0) * B.coeff(0, c);
      for (int k = 1; k < K; ++k) sum += A.coeff(r, k) * B.coeff(k, c);
      out[r + c * R] = sum;
    }
  }
  return Mat<S, R, C>(out);
}
/// A [a]x
template <class S, int R>
Mat<S, R, 3> product_hat(const Mat<S, R, 3>& A, const Vec<S, 3>& a) {
  S out[3 * R];
  for (int r = 0; r < R; ++r) out[r] = A.coeff(r, 1) * a[2] - A.coeff(r, 2) * a[1];
  for (int r = 0; r < R; ++r) out[r + R] = A.coeff(r, 2) * a[0] - A.coeff(r, 0) * a[2];
  for (int r = 0; r < R; ++r) out[r + 2 * R] = A.coeff(r, 0) * a[1] - A.coeff(r, 1) * a[0];
  return Mat<S, R, 3>(out);
}
/// A B^T
template <class S, int R, int K, int C>
Mat<S, R, C> product_transposed(const Mat<S, R, K>& A, const Mat<S, C, K>& B) {
  S out[R * C];
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) {
      S sum = A.coeff(r, 0) * B.coeff(c, 0);
      for (int k = 1; k < K; ++k) sum += A.coeff(r, k) * B.coeff(c, k);
      out[r + c * R] = sum;
    }
  }
  return Mat<S, R, C>(out);
}

}  // namespace plumbline
