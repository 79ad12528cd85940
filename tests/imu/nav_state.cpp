#include "plumbline/imu/nav_state.hpp"

#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("nav_state: minus undoes plus", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-6 : 1e-14;
  testing::Gaussian normal(1);
  for (int i = 0; i < 50; ++i) {
    const NavState<S> x = test::random_state(normal).cast<S>();
    const Vec<S, 15> d = (0.5 * normal.vector<15>()).cast<S>();
    REQUIRE((minus(plus(x, d), x) - d).norm() < 20 * tolerance);
  }
}

TEMPLATE_TEST_CASE("nav_state: order of the error", "", float, double) {
  using S = TestType;
  const NavState<S> x;
  for (int i = 0; i < 15; ++i) {
    const NavState<S> y = plus(x, Vec<S, 15>(S(0.25) * Vec<S, 15>::Unit(i)));
    Vec<S, 15> parts;
    parts << y.T_world_body.rotation().log(), y.T_world_body.p(), y.v_world_body, y.bias_gyro, y.bias_accel;
    REQUIRE((parts - S(0.25) * Vec<S, 15>::Unit(i)).norm() < S(1e-6));
  }
  STATIC_REQUIRE((NavState<S>::gyro_bias == 9 && NavState<S>::accel_bias == 12));
}

TEMPLATE_TEST_CASE("nav_state: Jacobian of minus", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(2);
  for (int i = 0; i < 50; ++i) {
    const NavState<double> x = test::random_state(normal), x0 = test::random_state(normal);
    if (minus(x, x0).head<3>().norm() > 3) continue;  // the logarithm jumps at pi
    const auto f = [&](const NavState<double>& y) { return minus(y, x0); };
    REQUIRE(testing::jacobian_error(minus_jacobian(x.cast<S>(), x0.cast<S>()), f, x) <
            (std::is_same_v<S, float> ? 1e-5 : 1e-9));
  }
}

TEST_CASE("nav_state: not finite") {
  NavState<double> x;
  REQUIRE(x.is_finite());
  x.bias_accel.y() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(!x.is_finite());
}
