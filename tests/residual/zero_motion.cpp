#include "plumbline/residual/zero_motion.hpp"

#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using testing::jacobian_error;

TEMPLATE_TEST_CASE("zero_motion: Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-9;
  testing::Gaussian normal(1);
  for (int i = 0; i < 40; ++i) {
    const SE3<double> T_i(SO3<double>::exp(normal.vector<3>()), normal.vector<3>());
    const SE3<double> T_j = plus(T_i, Vec<double, 6>((i % 2 == 0 ? 1e-5 : 0.5) * normal.vector<6>()));
    const auto lin = ZeroMotion<S>{}.linearize(T_i.cast<S>(), T_j.cast<S>());
    REQUIRE(lin.valid);
    REQUIRE(jacobian_error(
                lin.J_r_i, [&](const SE3<double>& T) { return minus(T_j, T); }, T_i) < tolerance);
    REQUIRE(jacobian_error(
                lin.J_r_j, [&](const SE3<double>& T) { return minus(T, T_i); }, T_j) < tolerance);
    const auto first = ZeroMotion<S>{}.linearize(T_j.cast<S>(), T_i.cast<S>(), T_i.cast<S>(), T_j.cast<S>());
    REQUIRE((first.J_r_i == lin.J_r_i && first.r != lin.r));

    const Vec<S, 3> v = normal.vector<3>().cast<S>();
    const auto velocity = ZeroVelocity<S>{}.linearize(v);
    REQUIRE((velocity.valid && velocity.r == v && velocity.J_r_v == Mat<S, 3, 3>::Identity()));
  }
}

TEST_CASE("zero_motion: nothing moves") {
  const SE3<double> T(SO3<double>::exp({1, 2, 3}), {4, 5, 6});
  REQUIRE(ZeroMotion<double>{}.linearize(T, T).r.norm() < 1e-15);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(!ZeroMotion<double>{}.linearize(T, SE3<double>(SO3<double>(), {nan, 0, 0})).valid);
  REQUIRE(!ZeroVelocity<double>{}.linearize({0, nan, 0}).valid);
}
