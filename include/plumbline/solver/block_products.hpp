#pragma once
/// Sums of products of a few rows, a_k and b_k of N numbers each, into one N x N block.
///
/// These are the inner loops of a window's solve: functions of their own, so that all in them is put into vectors.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

namespace detail {
/// Column d of G += sum_k a_k b_k^T, from row `first` on.
template <int first, class S, int N, std::size_t R>
EIGEN_ALWAYS_INLINE void add_column(const std::array<Vec<S, N>, R>& a, const std::array<Vec<S, N>, R>& b, int d,
                                    Mat<S, N, N>& G) {
  constexpr int alignment = N * sizeof(S) % 16 == 0 && first * sizeof(S) % 16 == 0 ? Eigen::Aligned16 : 0;
  using Part = Vec<S, N - first>;
  using Rows = Eigen::Map<const Part, alignment>;
  Part sum = b[0][d] * Rows(a[0].data() + first);
  for (std::size_t k = 1; k < R; ++k) sum += b[k][d] * Rows(a[k].data() + first);
  Eigen::Map<Part, alignment>(G.data() + d * N + first) += sum;
}
}  // namespace detail

/// G += sum_k a_k b_k^T
template <class S, int N, std::size_t R>
EIGEN_DONT_INLINE void add_product(const std::array<Vec<S, N>, R>& a, const std::array<Vec<S, N>, R>& b,
                                   Mat<S, N, N>& G) {
  for (int d = 0; d < N; ++d) detail::add_column<0>(a, b, d, G);
}

/// G += A B
template <class S, int N>
EIGEN_DONT_INLINE void add_product(const Mat<S, N, N>& A, const Mat<S, N, N>& B, Mat<S, N, N>& G) {
  using Column = Eigen::Map<const Vec<S, N>, N * sizeof(S) % 16 == 0 ? Eigen::Aligned16 : 0>;
  for (int c = 0; c < N; ++c) {
    Vec<S, N> sum = B(0, c) * Column(A.data());
    for (int k = 1; k < N; ++k) sum += B(k, c) * Column(A.data() + k * N);
    G.col(c) += sum;
  }
}

/// G += sum_k a_k a_k^T, its lower triangle and the entries right above it: even numbers keep vectors aligned.
template <class S, int N, std::size_t R>
EIGEN_DONT_INLINE void add_lower_product(const std::array<Vec<S, N>, R>& a, Mat<S, N, N>& G) {
  [&]<int... d>(std::integer_sequence<int, d...>) { (detail::add_column<d - d % 2>(a, a, d, G), ...); }
  (std::make_integer_sequence<int, N>{});
}

/// The symmetric block whose lower triangle is given.
template <class S, int N>
Mat<S, N, N> symmetric_block(const Mat<S, N, N>& lower) {
  Mat<S, N, N> out;
  for (int c = 0; c < N; ++c) {
    for (int r = c; r < N; ++r) out(r, c) = out(c, r) = lower(r, c);
  }
  return out;
}

}  // namespace plumbline
