#pragma once
/// Householder reflections I - tau v v^T with v = [1; tail], over one pivot row and a range of tail rows.
///                                                                                        docs/math/solver.md (10)

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace plumbline {

namespace detail {
/// Four numbers of a longer array: vectors with `-O2` too.
template <class S>
using Four = Eigen::Array<S, 4, 1>;
template <class S>
Eigen::Map<const Four<S>> four(const S* x) {
  return Eigen::Map<const Four<S>>(x);
}
template <class S>
Eigen::Map<Four<S>> four(S* x) {
  return Eigen::Map<Four<S>>(x);
}
}  // namespace detail

/// a.b of n numbers, in four sums: a compiler must not change the order of one.
template <class S>
S dot(const S* a, const S* b, int n) {
  using detail::four;
  detail::Four<S> sum(S(0), S(0), S(0), S(0));
  int k = 0;
  for (; k + 4 <= n; k += 4) sum += four(a + k) * four(b + k);
  for (; k < n; ++k) sum[0] += a[k] * b[k];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// y -= w x of n numbers.
template <class S>
void subtract_scaled(S w, const S* x, S* y, int n) {
  using detail::four;
  int k = 0;
  for (; k + 4 <= n; k += 4) four(y + k) -= w * four(x + k);
  for (; k < n; ++k) y[k] -= w * x[k];
}

/// The reflection that maps [pivot; tail], n numbers in the tail, to [beta; 0]: pivot becomes beta, the tail becomes
/// that of v, tau is returned (0, the identity, when the tail is zero).
template <class S>
S make_reflection(S& pivot, S* tail, int n) {
  const S tail_squared = dot(tail, tail, n);
  if (tail_squared == S(0)) return S(0);
  const S norm = std::sqrt(pivot * pivot + tail_squared), beta = pivot > S(0) ? -norm : norm;  // no cancellation
  const S scale = S(1) / (pivot - beta), tau = (beta - pivot) / beta;
  for (int k = 0; k < n; ++k) tail[k] *= scale;
  pivot = beta;
  return tau;
}

/// [pivot; tail] <- (I - tau v v^T) [pivot; tail].
template <class S>
void reflect(S tau, const S* v_tail, S& pivot, S* tail, int n) {
  const S w = tau * (pivot + dot(v_tail, tail, n));
  pivot -= w;
  subtract_scaled(w, v_tail, tail, n);
}

/// The same of a few rows of one number or some side by side, with the tail v of as many numbers.
template <class S, class T, std::size_t R>
void reflect_few(S tau, const std::array<S, R>& v, T& first, std::array<T, R>& rows) {
  T w = first;
  for (std::size_t i = 0; i < R; ++i) w += v[i] * rows[i];
  w = tau * w;
  first -= w;
  for (std::size_t i = 0; i < R; ++i) rows[i] -= v[i] * w;
}

/// Two reflections that have their tails in the same rows, one after the other, in one pass over them:
/// (I - tau_2 v_2 v_2^T) (I - tau_1 v_1 v_1^T) [pivot_1; pivot_2; tail], `product` their tails' v_1.v_2.
template <class S>
void reflect_twice(S tau_1, const S* v_1, S& pivot_1, S tau_2, const S* v_2, S& pivot_2, S product, S* tail, int n) {
  using detail::four;
  detail::Four<S> sum_1(S(0), S(0), S(0), S(0)), sum_2 = sum_1;
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    const detail::Four<S> x = four(tail + k);
    sum_1 += four(v_1 + k) * x;
    sum_2 += four(v_2 + k) * x;
  }
  for (; k < n; ++k) {
    sum_1[0] += v_1[k] * tail[k];
    sum_2[0] += v_2[k] * tail[k];
  }
  const S w_1 = tau_1 * (pivot_1 + (sum_1[0] + sum_1[1]) + (sum_1[2] + sum_1[3]));
  const S w_2 = tau_2 * (pivot_2 + (sum_2[0] + sum_2[1]) + (sum_2[2] + sum_2[3]) - w_1 * product);
  pivot_1 -= w_1;
  pivot_2 -= w_2;
  for (k = 0; k + 4 <= n; k += 4) four(tail + k) -= w_1 * four(v_1 + k) + w_2 * four(v_2 + k);
  for (; k < n; ++k) tail[k] -= w_1 * v_1[k] + w_2 * v_2[k];
}

/// A pivot below this part of the largest one counts as zero.                            docs/math/solver.md (13a)
template <class S>
inline constexpr S rank_tolerance = std::numeric_limits<S>::epsilon() > S(1e-10)
                                        ? 10 * std::numeric_limits<S>::epsilon()
                                        : S(1e-9);

/// Triangularizes the `count` leading columns of M (rows x cols, its columns `stride` apart) in place by reflections of
/// all of its rows, with pivoting among these columns. Returns their rank k: the rows from k on no longer contain them
/// (what is left there is set to zero), and are the constraints of M on the other columns.
template <class S>
int eliminate_leading_columns(S* M, int rows, int cols, int stride, int count) {
  S largest = S(0);
  int rank = 0;
  for (; rank < count && rank < rows; ++rank) {
    int best = rank;
    S best_squared = S(-1);
    for (int c = rank; c < count; ++c) {
      const S* const tail = M + c * stride + rank;
      const S squared = dot(tail, tail, rows - rank);
      if (squared > best_squared) best = c, best_squared = squared;
    }
    const S norm = std::sqrt(best_squared);
    if (rank == 0) largest = norm;
    if (!(norm > rank_tolerance<S> * largest)) break;
    S* const column = M + rank * stride;
    if (best != rank) std::swap_ranges(column, column + rows, M + best * stride);
    S* const tail = column + rank + 1;
    const int n = rows - rank - 1;
    const S tau = make_reflection(column[rank], tail, n);
    for (int c = rank + 1; tau != S(0) && c < cols; ++c) {
      S* const other = M + c * stride + rank;
      reflect(tau, tail, other[0], other + 1, n);
    }
    std::fill_n(tail, n, S(0));
  }
  for (int c = 0; c < count; ++c) std::fill_n(M + c * stride + rank, rows - rank, S(0));
  return rank;
}

}  // namespace plumbline
