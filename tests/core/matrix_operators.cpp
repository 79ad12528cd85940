// The operators of values against the expressions of Eigen, which are named here by their members.
#include "plumbline/core/matrix_operators.hpp"

#include <cmath>
#include <concepts>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"

using namespace plumbline;

namespace {

template <class S, int R, int C>
Mat<S, R, C> numbers(int seed) {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = std::sin(S(1 + 7 * k + 13 * seed));
  return out;
}

/// A B, A^T^T B and A B^T^T.
template <class S, int R, int K, int C>
void compare() {
  CAPTURE(R, K, C);
  for (int n = 0; n < 20; ++n) {
    const Mat<S, R, K> A = numbers<S, R, K>(n);
    const Mat<S, K, C> B = numbers<S, K, C>(n + 50);
    const Mat<S, K, R> At = A.transpose();
    const Mat<S, C, K> Bt = B.transpose();
    Mat<S, R, C> of_eigen = A.operator*(B);
    CHECK(Mat<S, R, C>(A * B) == of_eigen);
    of_eigen = A.operator*(Bt.transpose());
    CHECK(Mat<S, R, C>(A * Bt.transpose()) == of_eigen);
    of_eigen = At.transpose().operator*(B);
    CHECK(Mat<S, R, C>(At.transpose() * B) == of_eigen);
  }
}

}  // namespace

// Orders of sums are those of packets of 16 bytes without fused products.
#if defined(__SSE2__) && !defined(__AVX__)
TEMPLATE_TEST_CASE("matrix operators: products are those of Eigen to the last bit", "", float, double) {
  compare<TestType, 2, 2, 1>();
  compare<TestType, 2, 3, 3>();
  compare<TestType, 3, 3, 1>();
  compare<TestType, 3, 3, 3>();
  compare<TestType, 4, 4, 4>();
  compare<TestType, 6, 4, 4>();
  compare<TestType, 2, 6, 6>();
  compare<TestType, 6, 6, 1>();
  compare<TestType, 6, 6, 6>();
}
#endif

TEMPLATE_TEST_CASE("matrix operators: values, not expressions", "", float, double) {
  using S = TestType;
  const Vec<S, 3> a = numbers<S, 3, 1>(1), b = numbers<S, 3, 1>(2);
  const Mat<S, 3, 3> A = numbers<S, 3, 3>(3);
  STATIC_REQUIRE(std::same_as<decltype(a + b), Vec<S, 3>>);
  STATIC_REQUIRE(std::same_as<decltype(-a), Vec<S, 3>>);
  STATIC_REQUIRE(std::same_as<decltype(2 * a / S(3)), Vec<S, 3>>);
  STATIC_REQUIRE(std::same_as<decltype(A * a - b), Vec<S, 3>>);
  STATIC_REQUIRE(std::same_as<decltype(A.transpose() * A), Mat<S, 3, 3>>);
  STATIC_REQUIRE(std::same_as<decltype(a * b.transpose()), Mat<S, 3, 3>>);
  STATIC_REQUIRE(!std::same_as<decltype(numbers<S, 7, 7>(1) + numbers<S, 7, 7>(2)), Mat<S, 7, 7>>);  // too large
  for (int k = 0; k < 3; ++k) {
    CHECK((a + b)[k] == a[k] + b[k]);
    CHECK((a - b)[k] == a[k] - b[k]);
    CHECK((-a)[k] == -a[k]);
    CHECK((2 * a)[k] == 2 * a[k]);
    CHECK((a * S(0.3))[k] == a[k] * S(0.3));
    CHECK((a / S(3))[k] == a[k] / S(3));
    CHECK((a * b.transpose())(k, 1) == a[k] * b[1]);
  }
}
