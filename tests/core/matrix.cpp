#include "plumbline/core/matrix.hpp"

#include <Eigen/Geometry>

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
