#include "plumbline/state/pose_prior.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("pose_prior: not valid until it is set", "", float, double) {
  const PosePrior<TestType> prior;
  REQUIRE_FALSE(prior.valid);
  REQUIRE(prior.sigma.size() == state::Pose::dim);
  REQUIRE(prior.sigma.isZero(0));
}

TEMPLATE_TEST_CASE("pose_prior: passes_gate within its sigmas in each direction, and not for NaN", "", float, double) {
  using S = TestType;
  using Away = Vec<S, state::Pose::dim>;
  PosePrior<S> prior;
  REQUIRE(prior.passes_gate(Away::Constant(S(1e6)), S(2)));  // it is not valid
  prior = {true, Away::Constant(S(0.1))};
  prior.sigma[4] = S(0.01);
  Away d = Away::Constant(S(0.19));
  d[4] = S(-0.019);
  CHECK(prior.passes_gate(d, S(2)));
  d[4] = S(-0.021);
  CHECK_FALSE(prior.passes_gate(d, S(2)));
  CHECK(prior.passes_gate(d, S(3)));
  d[4] = std::numeric_limits<S>::quiet_NaN();
  CHECK_FALSE(prior.passes_gate(d, S(3)));
}
