// Functions of values against the equivalent members of Eigen.
#include "plumbline/core/matrix_functions.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {

template <class S, int R, int C = 1>
Mat<S, R, C> numbers(int seed) {
  Mat<S, R, C> out;
  for (int k = 0; k < R * C; ++k) out.data()[k] = std::sin(S(1 + 7 * k + 13 * seed));
  return out;
}

template <class S, int R, int C>
void compare_sums() {
  CAPTURE(R, C);
  for (int n = 0; n < 50; ++n) {
    const Mat<S, R, C> a = numbers<S, R, C>(n), b = numbers<S, R, C>(n + 50);
    CHECK(squared_norm(a) == a.squaredNorm());
    CHECK(norm(a) == a.norm());
    CHECK(dot(a, b) == a.cwiseProduct(b).sum());
    if constexpr (C == 1) CHECK(normalized(a) == a.normalized());
  }
}

}  // namespace

TEMPLATE_TEST_CASE("matrix functions: zeros, identity, columns and casts", "", float, double) {
  using S = TestType;
  using Other = std::conditional_t<std::same_as<S, float>, double, float>;
  CHECK(zeros<S, 3>() == Vec<S, 3>::Zero());
  CHECK(zeros<S, 9, 15>() == Mat<S, 9, 15>::Zero());
  CHECK(zeros<Mat<S, 2, 6>>() == Mat<S, 2, 6>::Zero());
  CHECK(identity<S, 4>() == Mat<S, 4, 4>::Identity());
  Eigen::Matrix<S, Eigen::Dynamic, 1, 0, 8, 1> some(5);
  some.setOnes();
  set_zero(some);
  CHECK(some.isZero(0));
  std::array<Vec<S, 3>, 2> each{numbers<S, 3>(1), numbers<S, 3>(2)};
  set_zero(each);
  CHECK((each[0].isZero(0) && each[1].isZero(0)));
  Mat<S, 3, 3> A = numbers<S, 3, 3>(3);
  CHECK(column(A, 2) == A.col(2));
  CHECK(cast_to<Other>(A) == A.template cast<Other>());
  CHECK(cwise_product(A, numbers<S, 3, 3>(4)) == A.cwiseProduct(numbers<S, 3, 3>(4)));
  CHECK(max_abs(A) == A.cwiseAbs().maxCoeff());
  for (int k = 0; k < 9; ++k) {
    Mat<S, 3, 3> damaged = A;
    damaged(k % 3, k / 3) = std::numeric_limits<S>::quiet_NaN();
    CHECK(std::isnan(max_abs(damaged)));
  }
  set_identity(A);
  CHECK(A == Mat<S, 3, 3>::Identity());
}

// Orders of sums are those of packets of 16 bytes without fused products.
#if defined(__SSE2__) && !defined(__AVX__)
TEMPLATE_TEST_CASE("matrix functions: sums are those of Eigen to the last bit", "", float, double) {
  compare_sums<TestType, 1, 1>();
  compare_sums<TestType, 2, 1>();
  compare_sums<TestType, 3, 1>();
  compare_sums<TestType, 4, 1>();
  compare_sums<TestType, 6, 1>();
  compare_sums<TestType, 9, 1>();
  compare_sums<TestType, 15, 1>();
  compare_sums<TestType, 2, 2>();
  compare_sums<TestType, 3, 3>();
  compare_sums<TestType, 6, 6>();
}

TEMPLATE_TEST_CASE("matrix functions: inverse, products and vectors across are those of Eigen", "", float, double) {
  using S = TestType;
  for (int n = 0; n < 50; ++n) {
    const Mat<S, 3, 3> A = numbers<S, 3, 3>(n) + identity<S, 3>();
    Mat<S, 3, 3> inverse;
    REQUIRE(invert(A, inverse));
    CHECK(inverse == A.inverse());
    const Mat<S, 2, 2> B = A.template topLeftCorner<2, 2>();
    Mat<S, 2, 2> inverse_of_two;
    REQUIRE(invert(B, inverse_of_two));
    CHECK(inverse_of_two == B.inverse());
    const Mat<S, 7, 7> H = numbers<S, 7, 7>(n);
    const Vec<S, 7> x = numbers<S, 7>(n + 50);
    CHECK(quadratic_form(H, x) == S(x.transpose() * H * x));
    CHECK(times(H, x) == Vec<S, 7>(H.lazyProduct(x)));  // as Eigen assigns it
    const Mat<S, 15, 15> L = numbers<S, 15, 15>(n);
    const Vec<S, 15> r = numbers<S, 15>(n);
    CHECK(times(L, r) == Vec<S, 15>(L.lazyProduct(r)));
    const Vec<S, 3> a = numbers<S, 3>(n);
    CHECK(unit_orthogonal(a) == a.unitOrthogonal());
  }
  const Vec<S, 3> up(S(1e-13), S(-1e-13), 2);
  CHECK(unit_orthogonal(up) == up.unitOrthogonal());
}
#endif

TEMPLATE_TEST_CASE("matrix functions: what has no inverse and no direction", "", float, double) {
  using S = TestType;
  Mat<S, 3, 3> inverse, A = identity<S, 3>();
  A(2, 2) = 0;
  CHECK(!invert(A, inverse));
  A(2, 2) = std::numeric_limits<S>::quiet_NaN();
  CHECK(!invert(A, inverse));
  Mat<S, 2, 2> B = Mat<S, 2, 2>::Ones(), inverse_of_two;
  CHECK(!invert(B, inverse_of_two));
  CHECK(normalized(zeros<S, 3>()) == zeros<S, 3>());
}
