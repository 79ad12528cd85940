#pragma once
/// L, lower triangular, with L^T L = covariance^-1: r -> L r has unit covariance.               docs/math/imu.md
///
///   covariance = C C^T,  L = C^-1.   Loops over fixed sizes: nothing for a heap, unlike Eigen's blocked
///   decompositions.

#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"

namespace plumbline {

/// Reads the lower triangle. Fails on what is not positive definite or not finite.
template <class S, int N>
Result<Mat<S, N, N>> square_root_information(const Mat<S, N, N>& covariance) {
  Eigen::Matrix<S, N, N, Eigen::RowMajor> C;
  Mat<S, N, N> L = Mat<S, N, N>::Zero();
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < i; ++j) C(i, j) = L(j, j) * (covariance(i, j) - C.row(i).head(j).dot(C.row(j).head(j)));
    const S pivot = covariance(i, i) - C.row(i).head(i).squaredNorm();
    if (!(pivot > S(0)) || !(pivot <= std::numeric_limits<S>::max())) return Error::not_positive_definite;
    L(i, i) = S(1) / std::sqrt(pivot);
    for (int j = 0; j < i; ++j) L(i, j) = -L(i, i) * C.row(i).segment(j, i - j).dot(L.col(j).segment(j, i - j));
  }
  return L;
}

}  // namespace plumbline
