#include "plumbline/imu/gravity.hpp"

#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("gravity: upright turns it down and removes yaw", "", float, double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-14);
  testing::Gaussian normal(1);
  for (int i = 0; i < 200; ++i) {
    Vec<S, 3> g = normal.vector<3>().cast<S>();
    if (i < 3) g = Vec<S, 3>::Unit(i);
    if (i >= 3 && i < 6) g = -Vec<S, 3>::Unit(i - 3);
    const SO3<S> R = upright(g);
    REQUIRE((R * Vec<S, 3>(g.normalized()) + Vec<S, 3>::UnitZ()).norm() < tolerance);
    const int axis = std::abs(g.normalized().x()) < S(0.7071) ? 0 : 2;
    const Vec<S, 3> heading = R.matrix().col(axis);
    REQUIRE((heading.x() > S(0.5) && std::abs(heading.y()) < tolerance));
  }
  REQUIRE((upright<S>({0, 0, S(-9.81)}).matrix() - Mat<S, 3, 3>::Identity()).norm() < tolerance);
  REQUIRE(gravity_in_world<S>() == Vec<S, 3>(0, 0, S(-9.81)));
}
