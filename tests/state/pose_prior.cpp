#include "plumbline/state/pose_prior.hpp"

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("pose_prior: believes nothing until it is told", "", float, double) {
  const PosePrior<TestType> prior;
  REQUIRE_FALSE(prior.valid);
  REQUIRE(prior.sigma.size() == state::Pose::dim);
  REQUIRE(prior.sigma.isZero(0));
}
