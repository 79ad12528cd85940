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

TEMPLATE_TEST_CASE("matrix: a number that is not finite is found", "", float, double) {
  Mat<TestType, 3, 2> m = Mat<TestType, 3, 2>::Ones();
  REQUIRE(all_finite(m));
  for (const TestType bad : {std::numeric_limits<TestType>::quiet_NaN(), -std::numeric_limits<TestType>::infinity()}) {
    m(2, 1) = bad;
    REQUIRE_FALSE(all_finite(m));
  }
}
