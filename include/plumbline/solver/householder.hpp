#pragma once
/// Householder reflections I - tau v v^T with v = [1; tail], over one pivot row and a range of tail rows.
///                                                                                        docs/math/solver.md (10)

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace plumbline {

/// The reflection that maps [pivot; tail] to [beta; 0]: pivot becomes beta, the tail becomes that of v, tau is returned
/// (0, the identity, when the tail is zero).
template <class S, class Tail>
S make_reflection(S& pivot, Tail&& tail) {
  const S tail_squared = tail.squaredNorm();
  if (tail_squared == S(0)) return S(0);
  const S norm = std::sqrt(pivot * pivot + tail_squared), beta = pivot > S(0) ? -norm : norm;  // no cancellation
  tail *= S(1) / (pivot - beta);
  const S tau = (beta - pivot) / beta;
  pivot = beta;
  return tau;
}

/// [pivot; tail] <- (I - tau v v^T) [pivot; tail].
template <class S, class V, class Tail>
void reflect(S tau, const Eigen::MatrixBase<V>& v_tail, S& pivot, Tail&& tail) {
  const S w = tau * (pivot + v_tail.dot(tail));
  pivot -= w;
  tail -= w * v_tail;
}

/// A pivot below this part of the largest one counts as zero.                            docs/math/solver.md (13)
template <class S>
inline constexpr S rank_tolerance = std::numeric_limits<S>::epsilon() > S(1e-10)
                                        ? 10 * std::numeric_limits<S>::epsilon()
                                        : S(1e-9);

/// Triangularizes the `count` leading columns of M in place by reflections of all of its rows, with pivoting among
/// these columns. Returns their rank k: the rows from k on no longer contain them (what is left there is set to zero),
/// and are all that M says about the other columns.
template <class Derived>
int eliminate_leading_columns(Eigen::MatrixBase<Derived>&& M, int count) {
  using S = typename Derived::Scalar;
  const int rows = int(M.rows()), cols = int(M.cols());
  S largest = S(0);
  int rank = 0;
  for (; rank < count && rank < rows; ++rank) {
    int best = rank;
    S best_squared = S(-1);
    for (int c = rank; c < count; ++c) {
      const S squared = M.col(c).tail(rows - rank).squaredNorm();
      if (squared > best_squared) best = c, best_squared = squared;
    }
    const S norm = std::sqrt(best_squared);
    if (rank == 0) largest = norm;
    if (!(norm > rank_tolerance<S> * largest)) break;
    if (best != rank) M.col(rank).swap(M.col(best));
    const int tail = rows - rank - 1;
    const S tau = make_reflection(M.coeffRef(rank, rank), M.col(rank).tail(tail));
    for (int c = rank + 1; tau != S(0) && c < cols; ++c) {
      reflect(tau, M.col(rank).tail(tail), M.coeffRef(rank, c), M.col(c).tail(tail));
    }
    M.col(rank).tail(tail).setZero();
  }
  M.leftCols(count).bottomRows(rows - rank).setZero();
  return rank;
}

}  // namespace plumbline
