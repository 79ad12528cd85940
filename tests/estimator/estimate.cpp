#include "plumbline/estimator/estimate.hpp"

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("estimate: before the first frame nothing is claimed", "", float, double) {
  const Estimate<TestType> none;
  CHECK(none.health.state == Health{}.state);
  CHECK_FALSE(none.health.state == HealthState::tracking);
  CHECK(none.covariance.trace() == 6);  // a radian and a meter
  CHECK((none.tracked == 0 && none.resets == 0 && !none.keyframe));
  CHECK(none.T_world_body.p().norm() == 0);
}
