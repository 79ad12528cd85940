#pragma once
// Random matrices of the solver's tests, uniform in [-1, 1).

#include <Eigen/Core>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"

namespace plumbline {

inline Eigen::MatrixXd random_matrix(Random& random, int rows, int cols) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return 2 * random.uniform() - 1; });
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
