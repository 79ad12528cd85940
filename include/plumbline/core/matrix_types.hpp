#pragma once
/// Fixed-size matrix aliases. Sizes are compile-time constants everywhere in the estimator: nothing here can allocate.

#include <Eigen/Core>

namespace plumbline {

template <class S, int N>
using Vec = Eigen::Matrix<S, N, 1>;

template <class S, int Rows, int Cols>
using Mat = Eigen::Matrix<S, Rows, Cols>;

}  // namespace plumbline
