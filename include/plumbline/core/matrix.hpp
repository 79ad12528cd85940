#pragma once
/// Fixed-size matrix aliases. Sizes are compile-time constants everywhere in the estimator: nothing here can allocate.

#include <Eigen/Core>
#include <cmath>

namespace plumbline {

template <class S, int N>
using Vec = Eigen::Matrix<S, N, 1>;

template <class S, int Rows, int Cols>
using Mat = Eigen::Matrix<S, Rows, Cols>;

/// [a]x with hat(a) * b = a x b.                                                          docs/conventions.md
template <class Derived>
Mat<typename Derived::Scalar, 3, 3> hat(const Eigen::MatrixBase<Derived>& a) {
  EIGEN_STATIC_ASSERT_VECTOR_SPECIFIC_SIZE(Derived, 3)
  using S = typename Derived::Scalar;
  Mat<S, 3, 3> out;
  out << S(0), -a.z(), a.y(), a.z(), S(0), -a.x(), -a.y(), a.x(), S(0);
  return out;
}

/// True when no number is NaN or infinite.
template <class Derived>
bool all_finite(const Eigen::PlainObjectBase<Derived>& m) {
  for (int k = 0; k < int(m.size()); ++k) {
    if (!std::isfinite(m.data()[k])) return false;
  }
  return true;
}

}  // namespace plumbline
