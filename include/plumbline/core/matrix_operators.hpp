#pragma once
/// + - * / of matrices and vectors of fixed size as functions of values, for all code in namespace plumbline.
///
/// For Eigen each operation is a class and a product is seven more, and what a compiler needs for an estimator grows
/// with the square of their number. Between plain values of up to max_numbers numbers nothing of that is needed.
/// Operands that are expressions themselves (blocks, arrays), larger or dynamic ones stay Eigen's.
///
/// Results are Eigen's: a sum of products is taken in order where rows of the result fill packets of 16 bytes, and by
/// halves elsewhere; of products with a transposed matrix on the left, packets are summed first:
///   (a_0 + a_1) + a_2   or   a_0 + (a_1 + a_2)                                                                  (1)

#include <Eigen/Core>
#include <concepts>

#include "plumbline/core/matrix_types.hpp"

namespace plumbline {

namespace detail {
constexpr int max_numbers = 36;
template <class S>
constexpr int packet_size = 16 / int(sizeof(S));

template <class S, int Rows, int Cols>
concept Values = std::floating_point<S> &&(Rows > 0) && (Cols > 0) && (Rows * Cols <= max_numbers);
template <class S, int R, int K, int C>
concept Factors = Values<S, R, K> && Values<S, K, C> && Values<S, R, C> &&(R > 1);
/// What Eigen multiplies a matrix of S by without a cast.
template <class T, class S>
concept ScalarOf = std::same_as<T, S> || std::integral<T>;

template <int N, class S>
EIGEN_STRONG_INLINE constexpr S sum_by_halves(const S* a) {
  if constexpr (N == 1) {
    return a[0];
  } else {
    return sum_by_halves<N / 2>(a) + sum_by_halves<N - N / 2>(a + N / 2);
  }
}
template <int N, class S>
EIGEN_STRONG_INLINE constexpr S sum_in_order(const S* a) {
  S sum = a[0];
  for (int k = 1; k < N; ++k) sum += a[k];
  return sum;
}
template <int N, class S>
EIGEN_STRONG_INLINE constexpr S sum_by_packets(const S* a) {
  constexpr int P = packet_size<S>, packets = N / P;
  if constexpr (packets == 0) {
    return sum_by_halves<N>(a);
  } else {
    S lanes[P], lane[packets];
    for (int k = 0; k < P; ++k) {
      for (int n = 0; n < packets; ++n) lane[n] = a[n * P + k];
      lanes[k] = sum_by_halves<packets>(lane);
    }
    for (int half = P / 2; half > 0; half /= 2) {
      for (int k = 0; k < half; ++k) lanes[k] += lanes[k + half];
    }
    if constexpr (N % P == 0) {
      return lanes[0];
    } else {
      return lanes[0] + sum_by_halves<N % P>(a + packets * P);
    }
  }
}

enum class Transposed : unsigned char { none, left, right };

/// A B, R x K by K x C, each of them column by column; of one that is transposed, what it is transposed of is given.
template <int R, int K, int C, Transposed transposed, class S>
EIGEN_ALWAYS_INLINE void multiply(const S* A, const S* B, S* result) {
  S out[R * C];  // a compiler has to assume that `result` aliases A or B, and would not vectorize
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) {
      S a[K];
      for (int k = 0; k < K; ++k) {
        a[k] = A[transposed == Transposed::left ? k + r * K : r + k * R] *
               B[transposed == Transposed::right ? c + k * C : k + c * K];
      }
      if constexpr (transposed == Transposed::left) {
        out[r + c * R] = sum_by_packets<K>(a);
      } else {
        out[r + c * R] = r < R - R % packet_size<S> ? sum_in_order<K>(a) : sum_by_halves<K>(a);
      }
    }
  }
  for (int k = 0; k < R * C; ++k) result[k] = out[k];
}
}  // namespace detail

template <class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator+(const Mat<S, R, C>& a,
                                           const Mat<S, R, C>& b) requires detail::Values<S, R, C> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = a.data()[k] + b.data()[k];
  return out;
}
template <class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator-(const Mat<S, R, C>& a,
                                           const Mat<S, R, C>& b) requires detail::Values<S, R, C> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = a.data()[k] - b.data()[k];
  return out;
}
template <class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator-(const Mat<S, R, C>& a) requires detail::Values<S, R, C> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = -a.data()[k];
  return out;
}

template <class T, class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(
    const T& factor, const Mat<S, R, C>& a) requires detail::Values<S, R, C> && detail::ScalarOf<T, S> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = S(factor) * a.data()[k];
  return out;
}
template <class T, class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(const Mat<S, R, C>& a,
                                           const T& factor) requires detail::Values<S, R, C> && detail::ScalarOf<T, S> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = a.data()[k] * S(factor);
  return out;
}
template <class T, class S, int R, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator/(
    const Mat<S, R, C>& a, const T& divisor) requires detail::Values<S, R, C> && detail::ScalarOf<T, S> {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = a.data()[k] / S(divisor);
  return out;
}

template <class S, int R, int K, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(const Mat<S, R, K>& A,
                                           const Mat<S, K, C>& B) requires detail::Factors<S, R, K, C> &&(K > 1) {
  Mat<S, R, C> out;
  detail::multiply<R, K, C, detail::Transposed::none>(A.data(), B.data(), out.data());
  return out;
}
template <class S, int R, int K, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(const Eigen::Transpose<const Mat<S, K, R>>& At,
                                           const Mat<S, K, C>& B) requires detail::Factors<S, R, K, C> &&(K > 1) {
  Mat<S, R, C> out;
  detail::multiply<R, K, C, detail::Transposed::left>(At.nestedExpression().data(), B.data(), out.data());
  return out;
}
template <class S, int R, int K, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(const Eigen::Transpose<Mat<S, K, R>>& At,
                                           const Mat<S, K, C>& B) requires detail::Factors<S, R, K, C> &&(K > 1) {
  Mat<S, R, C> out;
  detail::multiply<R, K, C, detail::Transposed::left>(At.nestedExpression().data(), B.data(), out.data());
  return out;
}
template <class S, int R, int K, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(
    const Mat<S, R, K>& A, const Eigen::Transpose<const Mat<S, C, K>>& Bt) requires detail::Factors<S, R, K, C> {
  Mat<S, R, C> out;
  detail::multiply<R, K, C, detail::Transposed::right>(A.data(), Bt.nestedExpression().data(), out.data());
  return out;
}
template <class S, int R, int K, int C>
EIGEN_STRONG_INLINE Mat<S, R, C> operator*(
    const Mat<S, R, K>& A, const Eigen::Transpose<Mat<S, C, K>>& Bt) requires detail::Factors<S, R, K, C> {
  Mat<S, R, C> out;
  detail::multiply<R, K, C, detail::Transposed::right>(A.data(), Bt.nestedExpression().data(), out.data());
  return out;
}

}  // namespace plumbline
