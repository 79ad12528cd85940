#pragma once
/// L, lower triangular, with L^T L = covariance^-1: r -> L r has unit covariance.               docs/math/imu.md
///
///   covariance = C C^T,  L = C^-1
/// Loops over fixed sizes: nothing for a heap, unlike Eigen's blocked decompositions.

#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"

namespace plumbline {

/// Reads the lower triangle. Fails on what is not positive definite or not finite.
template <class S, int N>
Result<Mat<S, N, N>> square_root_information(const Mat<S, N, N>& covariance) {
  S C[N][N];
  Mat<S, N, N> L = zeros<S, N, N>();
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < i; ++j) {
      S sum = S(0);
      for (int k = 0; k < j; ++k) sum += C[i][k] * C[j][k];
      C[i][j] = L(j, j) * (covariance(i, j) - sum);
    }
    S pivot = covariance(i, i);
    for (int k = 0; k < i; ++k) pivot -= C[i][k] * C[i][k];
    if (!(pivot > S(0)) || !(pivot <= std::numeric_limits<S>::max())) return Error::not_positive_definite;
    L(i, i) = S(1) / std::sqrt(pivot);
    for (int j = 0; j < i; ++j) {
      S sum = S(0);
      for (int k = j; k < i; ++k) sum += C[i][k] * L(k, j);
      L(i, j) = -L(i, i) * sum;
    }
  }
  return L;
}

}  // namespace plumbline
