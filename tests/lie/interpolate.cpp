#include "plumbline/lie/interpolate.hpp"

#include <limits>

#include "group_laws.hpp"

using namespace plumbline;
using testing::random_tangent;

TEMPLATE_TEST_CASE("interpolate: ends, middle and Jacobians", "", float, double) {
  using S = TestType;
  const bool single = std::is_same_v<S, float>;
  Random random(9);
  for (int turn = 0; turn < 300; ++turn) {
    const SE3<S> T0 = SE3<S>::exp(random_tangent<SE3<S>>(random, 3 * random.uniform()));
    const double angle = turn % 2 ? 3 * random.uniform() : std::pow(10, -8 * random.uniform());
    const SE3<S> T1 = plus(T0, random_tangent<SE3<S>>(random, angle));
    CHECK(testing::distance(interpolate(T0, T1, S(0)).T, T0) < (single ? S(1e-5) : S(1e-13)));
    CHECK(testing::distance(interpolate(T0, T1, S(1)).T, T1) < (single ? S(1e-5) : S(1e-13)));
    const S a = S(random.uniform());
    const InterpolatedPose<S> at = interpolate(T0, T1, a);
    REQUIRE(at.valid);
    CHECK(testing::distance(interpolate(T1, T0, 1 - a).T, at.T) < (single ? S(1e-5) : S(1e-13)));

    const SE3<double> exact0 = T0.template cast<double>(), exact1 = T1.template cast<double>();
    const SE3<double> middle = interpolate(exact0, exact1, double(a)).T;
    const auto of0 = [&](const SE3<double>& T) { return minus(interpolate(T, exact1, double(a)).T, middle); };
    const auto of1 = [&](const SE3<double>& T) { return minus(interpolate(exact0, T, double(a)).T, middle); };
    CHECK(testing::jacobian_error(at.J_T_T0, of0, exact0) < (single ? 2e-5 : 1e-8));
    CHECK(testing::jacobian_error(at.J_T_T1, of1, exact1) < (single ? 2e-5 : 1e-8));
  }
}

TEMPLATE_TEST_CASE("interpolate: refuses half turns, extrapolation and NaN", "", float, double) {
  using S = TestType;
  const SE3<S> T0, far(SO3<S>::exp({0, S(3.1), 0}), {1, 0, 0}), near(SO3<S>::exp({0, S(3), 0}), {1, 0, 0});
  CHECK(interpolate(T0, near, S(0.5)).valid);
  CHECK(!interpolate(T0, far, S(0.5)).valid);
  CHECK(!interpolate(T0, near, S(1.01)).valid);
  CHECK(!interpolate(T0, near, S(-0.01)).valid);
  CHECK(!interpolate(T0, near, std::numeric_limits<S>::quiet_NaN()).valid);
  const SE3<S> broken(SO3<S>::exp({0, std::numeric_limits<S>::quiet_NaN(), 0}), {0, 0, 0});
  CHECK(!interpolate(T0, broken, S(0.5)).valid);
}
