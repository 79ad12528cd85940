#include "plumbline/solver/symmetric_eigen.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

template <class S, int N>
Mat<S, N, N> random_symmetric(Random& random) {
  Mat<S, N, N> A;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = S(2 * random.uniform() - 1);
  }
  return A;
}

template <class S, int N>
void check(const Mat<S, N, N>& A) {
  const SymmetricEigen<S, N> eigen(A);
  REQUIRE(eigen.valid);
  Mat<S, N, N> scaled = eigen.V;
  for (int k = 0; k < N; ++k) {
    for (int i = 0; i < N; ++i) scaled(i, k) *= eigen.values[k];
    if (k > 0) CHECK(eigen.values[k] <= eigen.values[k - 1]);
  }
  const S tolerance = 20 * N * std::numeric_limits<S>::epsilon() * std::max(S(1), S(A.norm()));
  CHECK((product_transposed(scaled, eigen.V) - A).norm() < tolerance);
  CHECK((product_transposed(eigen.V, eigen.V) - Mat<S, N, N>::Identity()).norm() < tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("symmetric_eigen: V diag(values) V^T = A, V orthonormal, values descending", "", float, double) {
  using S = TestType;
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    check(random_symmetric<S, 3>(random));
    check(random_symmetric<S, 4>(random));
    check(random_symmetric<S, 9>(random));
  }
}

TEMPLATE_TEST_CASE("symmetric_eigen: equal, zero and far apart eigenvalues", "", float, double) {
  using S = TestType;
  check<S, 3>(Mat<S, 3, 3>::Identity());
  check<S, 3>(Mat<S, 3, 3>::Zero());
  check<S, 3>(Mat<S, 3, 3>::Constant(S(1)));
  Mat<S, 3, 3> A = Mat<S, 3, 3>::Zero();
  A(0, 0) = S(1e-12);
  A(2, 2) = S(1e6);
  A(0, 2) = A(2, 0) = S(1e-9);
  check<S, 3>(A);
}

TEST_CASE("symmetric_eigen: not for NaN") {
  Mat<double, 3, 3> A = Mat<double, 3, 3>::Identity();
  A(1, 2) = A(2, 1) = std::nan("");
  CHECK(!SymmetricEigen<double, 3>(A).valid);
}
