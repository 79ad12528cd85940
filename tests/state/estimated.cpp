#include "plumbline/state/estimated.hpp"

#include "catch.hpp"
#include "plumbline/state/block.hpp"

using namespace plumbline;

namespace {

template <class S>
Vec<S, 6> step_of(double a, double b, double c, double d, double e, double f) {
  return (Vec<double, 6>() << a, b, c, d, e, f).finished().template cast<S>();
}
template <class S>
constexpr S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-12);

}  // namespace

TEMPLATE_TEST_CASE("estimated: a free pose composes, a fixed one adds its corrections up", "", float, double) {
  using S = TestType;
  using Pose = Estimated<state::Pose, S>;
  const SE3<S> T(SO3<S>::exp({S(0.3), S(-0.2), S(0.5)}), Vec<S, 3>(1, 2, 3));
  const Vec<S, 6> a = step_of<S>(0.1, 0.2, -0.1, 0.3, 0.1, 0.2), b = step_of<S>(-0.2, 0.1, 0.3, 0.1, -0.4, 0.2);

  Pose free(T);
  free.add(a);
  free.add(b);
  REQUIRE(minus(free.value(), plus(plus(T, a), b)).norm() < tolerance<S>);
  REQUIRE(minus(free.first_estimate(), free.value()).norm() == 0);
  REQUIRE(free.correction().norm() == 0);

  Pose fixed(T);
  fixed.fix_first_estimate();
  fixed.add(a);
  fixed.add(b);
  REQUIRE(minus(fixed.first_estimate(), T).norm() == 0);
  REQUIRE((fixed.correction() - a - b).norm() < tolerance<S>);
  REQUIRE(minus(fixed.value(), plus(T, Vec<S, 6>(a + b))).norm() < tolerance<S>);
}

TEMPLATE_TEST_CASE("estimated: the same of a vector", "", float, double) {
  using S = TestType;
  const Vec<S, 3> x(1, 2, 3), first(1, 2, 4), d(S(0.5), 0, 0);
  Estimated<state::Velocity, S> velocity(x, first);
  REQUIRE(velocity.correction() == Vec<S, 3>(0, 0, -1));
  velocity.add(d);
  REQUIRE(velocity.value() == x + d);
  REQUIRE(velocity.first_estimate() == first + d);
  velocity.fix_first_estimate();
  velocity.add(d);
  REQUIRE(velocity.value() == x + 2 * d);
  REQUIRE(velocity.first_estimate() == first + d);
  REQUIRE(velocity.correction() == x - first + d);
}

TEMPLATE_TEST_CASE("estimated: value = first estimate [+] correction, of a pose that is off its first estimate", "",
                   float, double) {
  using S = TestType;
  const SE3<S> T(SO3<S>::exp({S(0.3), S(-0.2), S(0.5)}), Vec<S, 3>(1, 2, 3));
  const Vec<S, 6> a = step_of<S>(0.1, 0.2, -0.1, 0.3, 0.1, 0.2);
  Estimated<state::Pose, S> pose(plus(T, a), T);
  REQUIRE((pose.correction() - a).norm() < tolerance<S>);
  for (const bool fixed : {false, true}) {
    if (fixed) pose.fix_first_estimate();
    pose.add(a);
    REQUIRE(minus(pose.value(), plus(pose.first_estimate(), pose.correction())).norm() < tolerance<S>);
  }
}

TEST_CASE("estimated: the default is the identity, or zero") {
  REQUIRE(Estimated<state::Pose, double>().value().log().norm() == 0);
  REQUIRE(Estimated<state::GyroBias, float>().value().isZero(0));
  REQUIRE(Estimated<state::GyroBias, float>().correction().isZero(0));
}
