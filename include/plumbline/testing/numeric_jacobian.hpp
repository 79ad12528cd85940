#pragma once
/// Analytic Jacobians against central differences, evaluated in double whatever the scalar under test.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/plus.hpp"

namespace plumbline::testing {

/// Fourth-order central difference of f at x along the retraction `plus`; f returns a fixed-size vector of double.
template <int Rows, int Cols, class F, class X>
Mat<double, Rows, Cols> numeric_jacobian(F&& f, const X& x, double step = 1e-4) {
  Mat<double, Rows, Cols> J;
  const auto at = [&](int i, double h) -> Vec<double, Rows> {
    return f(plus(x, Vec<double, Cols>(h * Vec<double, Cols>::Unit(i))));
  };
  for (int i = 0; i < Cols; ++i) {
    J.col(i) = (8 * (at(i, step) - at(i, -step)) - (at(i, 2 * step) - at(i, -2 * step))) / (12 * step);
  }
  return J;
}

/// Difference between an analytic Jacobian and the numeric one, relative to its own size (absolute below 1).
template <class DJ, class F, class X>
double jacobian_error(const Eigen::MatrixBase<DJ>& J, F&& f, const X& x, double step = 1e-4) {
  constexpr int rows = DJ::RowsAtCompileTime, cols = DJ::ColsAtCompileTime;
  const Mat<double, rows, cols> numeric = numeric_jacobian<rows, cols>(f, x, step);
  return (numeric - J.template cast<double>()).norm() / std::max(1.0, numeric.norm());
}

}  // namespace plumbline::testing
