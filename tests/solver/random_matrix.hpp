#pragma once
// Random matrices of the solver's tests, uniform in [-1, 1) and multiples of 2^-21: float and double hold the same
// numbers.

#include <Eigen/Core>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"

namespace plumbline {

inline Eigen::MatrixXd random_matrix(Random& random, int rows, int cols) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return random.below(1u << 22) * 0x1p-21 - 1; });
}

/// A, rounded to such multiples.
inline Eigen::MatrixXd rounded(const Eigen::MatrixXd& A) {
  return A.unaryExpr([](double x) { return std::round(x * 0x1p21) * 0x1p-21; });
}

template <class S, int R, int C>
Mat<S, R, C> random_matrix(Random& random) {
  return random_matrix(random, R, C).cast<S>();
}

/// The symmetric matrix whose lower triangle is given.
template <class D>
Eigen::MatrixXd symmetric(const Eigen::MatrixBase<D>& lower) {
  Eigen::MatrixXd A = lower.template cast<double>();
  return A.selfadjointView<Eigen::Lower>();
}

inline double relative_error(const Eigen::MatrixXd& value, const Eigen::MatrixXd& expected) {
  return (value - expected).norm() / expected.norm();
}

}  // namespace plumbline
