#include "plumbline/lie/plus.hpp"

#include "group_laws.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("plus: rotation and translation apart, translation in the body frame", "", float, double) {
  using S = TestType;
  const SE3<S> T(SO3<S>::exp({0, 0, S(1.5707963267948966)}), {1, 2, 3});
  Vec<S, 6> d;
  d << 0, 0, S(0.1), 1, 0, 0;
  const SE3<S> moved = plus(T, d);
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  CHECK((moved.p() - Vec<S, 3>(1, 3, 3)).norm() < tolerance);  // the old orientation carries the step
  CHECK(testing::distance(moved.rotation(), SO3<S>::exp({0, 0, S(1.6707963267948966)})) < tolerance);
  Vec<S, 6> d_exp = d;
  CHECK(testing::distance(T * SE3<S>::exp(d_exp), moved) > S(0.01));  // it is not the exponential
}

TEMPLATE_TEST_CASE("plus: similarity", "", float, double) {
  using S = TestType;
  const Sim3<S> X(2, SO3<S>::exp({0, 0, S(1.5707963267948966)}), {1, 2, 3});
  Vec<S, 7> d;
  d << 0, 0, 0, 1, 0, 0, S(0.6931471805599453);
  const Sim3<S> moved = plus(X, d);
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  CHECK(std::abs(moved.scale() - 4) < 4 * tolerance);
  CHECK((moved.t() - Vec<S, 3>(1, 4, 3)).norm() < 4 * tolerance);
}

TEST_CASE("plus: vectors add") { CHECK(plus(Vec<double, 2>(1, 2), Vec<double, 2>(3, 4)) == Vec<double, 2>(4, 6)); }
