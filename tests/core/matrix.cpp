#include "plumbline/core/matrix.hpp"

#include <Eigen/Geometry>
#include <limits>

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("matrix: hat is the cross product", "", float, double) {
  using S = TestType;
  const Vec<S, 3> a(1, -2, 3), b(4, 5, -6);
  CHECK(hat(a) * b == a.cross(b));
  CHECK(hat(a).transpose() == -hat(a));
  CHECK(hat(a + b) == hat(a) + hat(b));  // takes expressions
  Vec<S, 6> c;
  c << a, b;
  CHECK(hat(c.template tail<3>()) == hat(b));
}

TEMPLATE_TEST_CASE("matrix: parts and products are those of Eigen", "", float, double) {
  using S = TestType;
  Mat<S, 5, 7> A;
  Mat<S, 7, 3> B;
  for (int i = 0; i < 35; ++i) A(i / 7, i % 7) = S(i % 11) - 3;  // small integers: every sum is exact
  for (int i = 0; i < 21; ++i) B(i / 3, i % 3) = S(i % 5) - 1;
  CHECK(block<2, 4>(A, 3, 1) == A.template block<2, 4>(3, 1));
  CHECK(product(A, B) == A * B);
  CHECK(product(Mat<S, 1, 7>(A.row(2)), B) == A.row(2) * B);
  CHECK(product_transposed(A, Mat<S, 3, 7>(B.transpose())) == A * B);

  Mat<S, 5, 7> copy = A;
  set_block(copy, 2, 4, block<3, 3>(B, 1, 0));
  CHECK(copy.template block<3, 3>(2, 4) == B.template block<3, 3>(1, 0));
  copy.template block<3, 3>(2, 4) = A.template block<3, 3>(2, 4);
  CHECK(copy == A);  // nothing else was written

  Vec<S, 5> x = A.col(1);
  CHECK(segment<2>(x, 3) == x.template tail<2>());
  set_segment(x, 1, Vec<S, 2>(S(8), S(9)));
  CHECK(x == (Vec<S, 5>() << A(0, 1), S(8), S(9), A(3, 1), A(4, 1)).finished());
}

TEMPLATE_TEST_CASE("matrix: a number that is not finite is found", "", float, double) {
  Mat<TestType, 3, 2> m = Mat<TestType, 3, 2>::Ones();
  REQUIRE(all_finite(m));
  for (const TestType bad : {std::numeric_limits<TestType>::quiet_NaN(), -std::numeric_limits<TestType>::infinity()}) {
    m(2, 1) = bad;
    REQUIRE_FALSE(all_finite(m));
  }
}
