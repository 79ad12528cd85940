#pragma once
/// Zeros, sums of products and the like of matrices and vectors of fixed size, as functions of values. Members of
/// Eigen's do the same; but there each of them is a few more classes to compile for every size.
///
/// Results are Eigen's to the last bit: of sums, whole packets of 16 bytes come first, see matrix_operators.hpp (1).

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "plumbline/core/matrix_operators.hpp"
#include "plumbline/core/matrix_types.hpp"

namespace plumbline {

template <class Derived>
EIGEN_STRONG_INLINE void set_zero(Eigen::PlainObjectBase<Derived>& m) {
  using S = typename Derived::Scalar;
  for (Eigen::Index k = 0; k < m.size(); ++k) m.data()[k] = S(0);
}
template <class Matrix, std::size_t N>
EIGEN_STRONG_INLINE void set_zero(std::array<Matrix, N>& each) {
  for (Matrix& m : each) set_zero(m);
}

/// Of a type, zeros<Covariance>(), or of a size, zeros<S, 6, 6>().
template <class Matrix>
EIGEN_STRONG_INLINE Matrix zeros() {
  Matrix out;
  set_zero(out);
  return out;
}
template <class S, int R, int C = 1>
EIGEN_STRONG_INLINE Mat<S, R, C> zeros() {
  return zeros<Mat<S, R, C>>();
}

template <class S, int N>
EIGEN_STRONG_INLINE void set_identity(Mat<S, N, N>& A) {
  set_zero(A);
  for (int k = 0; k < N; ++k) A.coeffRef(k, k) = S(1);
}
template <class S, int N>
EIGEN_STRONG_INLINE Mat<S, N, N> identity() {
  Mat<S, N, N> out;
  set_identity(out);
  return out;
}

/// The numbers of A as those of another type.
template <class To, class S, int R, int C>
EIGEN_STRONG_INLINE Mat<To, R, C> cast_to(const Mat<S, R, C>& A) {
  Mat<To, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = static_cast<To>(A.data()[k]);
  return out;
}

template <class S, int R, int C>
EIGEN_STRONG_INLINE Vec<S, R> column(const Mat<S, R, C>& A, int j) {
  Vec<S, R> out;
  for (int i = 0; i < R; ++i) out.coeffRef(i) = A.coeff(i, j);
  return out;
}

template <class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> cwise_product(const Mat<S, R, C>& a, const Mat<S, R, C>& b) {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = a.data()[k] * b.data()[k];
  return out;
}

/// a . b; of matrices, the sum over all their numbers.
template <class S, int R, int C>
EIGEN_STRONG_INLINE S dot(const Mat<S, R, C>& a, const Mat<S, R, C>& b) requires detail::Values<S, R, C> {
  S products[R * C];
  for (int k = 0; k < R * C; ++k) products[k] = a.data()[k] * b.data()[k];
  return detail::sum_by_packets<R * C>(products);
}
template <class S, int R, int C>
EIGEN_STRONG_INLINE S squared_norm(const Mat<S, R, C>& A) requires detail::Values<S, R, C> {
  S squares[R * C];
  for (int k = 0; k < R * C; ++k) squares[k] = A.data()[k] * A.data()[k];
  return detail::sum_by_packets<R * C>(squares);
}
/// A x of any size
template <class S, int R, int C>
Vec<S, R> times(const Mat<S, R, C>& A, const Vec<S, C>& x) {
  Vec<S, R> out;
  detail::multiply<R, C, 1, detail::Transposed::none>(A.data(), x.data(), out.data());
  return out;
}
/// x^T A x
template <class S, int N>
S quadratic_form(const Mat<S, N, N>& A, const Vec<S, N>& x) {
  Vec<S, N> xA;
  for (int k = 0; k < N; ++k) xA.coeffRef(k) = dot(x, column(A, k));
  return dot(xA, x);
}
template <class S, int R, int C>
EIGEN_STRONG_INLINE S norm(const Mat<S, R, C>& A) {
  return std::sqrt(squared_norm(A));
}
/// a / |a|, or zero where a is.
template <class S, int N>
EIGEN_STRONG_INLINE Vec<S, N> normalized(const Vec<S, N>& a) {
  const S squared = squared_norm(a);
  return squared > S(0) ? Vec<S, N>(a / std::sqrt(squared)) : a;
}

/// The largest |a_k|; NaN where one of them is.
template <class S, int R, int C>
S max_abs(const Mat<S, R, C>& A) {
  S out = S(0);
  for (int k = 0; k < R * C; ++k) {
    const S a = std::abs(A.data()[k]);
    if (!(a <= out) && !std::isnan(out)) out = a;
  }
  return out;
}

/// A unit vector across a.
template <class S>
Vec<S, 3> unit_orthogonal(const Vec<S, 3>& a) {
  const S much_smaller = Eigen::NumTraits<S>::dummy_precision() * std::abs(a[2]);
  if (!(std::abs(a[0]) <= much_smaller) || !(std::abs(a[1]) <= much_smaller)) {
    const S scale = S(1) / std::sqrt(a[0] * a[0] + a[1] * a[1]);
    return {-a[1] * scale, a[0] * scale, S(0)};
  }
  const S scale = S(1) / std::sqrt(a[1] * a[1] + a[2] * a[2]);
  return {S(0), -a[2] * scale, a[1] * scale};
}

/// By cofactors. False where the determinant is zero or NaN.
template <class S>
bool invert(const Mat<S, 2, 2>& A, Mat<S, 2, 2>& inverse) {
  const S determinant = A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0);
  if (!(std::abs(determinant) > S(0))) return false;
  const S factor = S(1) / determinant;
  inverse << factor * A(1, 1), -factor * A(0, 1), -factor * A(1, 0), factor * A(0, 0);
  return true;
}
template <class S>
bool invert(const Mat<S, 3, 3>& A, Mat<S, 3, 3>& inverse) {
  const auto cofactor = [&A](int i, int j) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return A.coeff(i1, j1) * A.coeff(i2, j2) - A.coeff(i1, j2) * A.coeff(i2, j1);
  };
  const S determinant = dot(Vec<S, 3>(cofactor(0, 0), cofactor(1, 0), cofactor(2, 0)), column(A, 0));
  if (!(std::abs(determinant) > S(0))) return false;
  const S factor = S(1) / determinant;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) inverse.coeffRef(j, i) = cofactor(i, j) * factor;
  }
  return true;
}

}  // namespace plumbline
