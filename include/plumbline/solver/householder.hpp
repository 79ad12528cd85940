#pragma once
/// Householder reflections I - tau v v^T with v = [1; tail], over one pivot row and a range of tail rows.
///                                                                                        docs/math/solver.md (10)

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline {

/// a.b of n numbers, in four sums: a compiler must not change the order of one.
template <class S>
S dot(const S* a, const S* b, int n) {
  S sum[4] = {};
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    for (int m = 0; m < 4; ++m) sum[m] += a[k + m] * b[k + m];
  }
  for (; k < n; ++k) sum[0] += a[k] * b[k];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
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
  for (int k = 0; k < n; ++k) tail[k] -= w * v_tail[k];
}

/// A pivot below this part of the largest one counts as zero.                            docs/math/solver.md (13)
template <class S>
inline constexpr S rank_tolerance = std::numeric_limits<S>::epsilon() > S(1e-10)
                                        ? 10 * std::numeric_limits<S>::epsilon()
                                        : S(1e-9);

/// Triangularizes the `count` leading columns of M (rows x cols, its columns `stride` apart) in place by reflections of
/// all of its rows, with pivoting among these columns. Returns their rank k: the rows from k on no longer contain them
/// (what is left there is set to zero), and are all that M says about the other columns.
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
