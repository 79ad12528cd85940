#include "plumbline/state/readout_estimate.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("readout_estimate: the estimate is the readout time, within its limits", "", float, double) {
  using S = TestType;
  ReadoutEstimate<S> estimate({S(0.01), S(0.02)}, {});
  estimate.correct(S(0.014), S(0.001));
  REQUIRE(estimate.readout().value_s == Approx(0.024));
  REQUIRE(estimate.readout().sigma_s == S(0.001));
  REQUIRE(estimate.found_s() == estimate.readout().value_s);
  estimate.correct(S(-0.1), S(0.001));
  REQUIRE(estimate.readout().value_s == S(0));
  estimate.correct(S(0.1), S(0.001));
  REQUIRE(estimate.readout().value_s == S(0.05));
}

TEMPLATE_TEST_CASE("readout_estimate: a correction that is not finite, or to a known value, changes nothing", "", float,
                   double) {
  using S = TestType;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  ReadoutEstimate<S> estimate({S(0.01), S(0.02)}, {}), known({S(0.01), S(0)}, {});
  estimate.correct(nan, S(0.001));
  estimate.correct(S(0.01), nan);
  estimate.correct(S(0.01), S(0));
  known.correct(S(0.01), S(0.001));
  for (const auto& x : {estimate, known}) REQUIRE(x.readout().value_s == S(0.01));
  REQUIRE(estimate.readout().sigma_s == S(0.02));
  REQUIRE(known.readout().is_known());
}

TEMPLATE_TEST_CASE("readout_estimate: a fixed value is replaced by a significant estimate", "", float, double) {
  using S = TestType;
  ReadoutEstimate<S> estimate({S(0), S(0.02), true}, {});
  estimate.correct(S(0.005), S(0.0005));  // many sigma, few milliseconds
  REQUIRE(estimate.readout().value_s == S(0));
  REQUIRE(estimate.found_s() == Approx(0.005));
  estimate.correct(S(0.02), S(0.005));  // many milliseconds, few sigma
  REQUIRE(estimate.readout().is_held);
  estimate.correct(S(0.02), S(0.003));
  REQUIRE_FALSE(estimate.readout().is_held);
  REQUIRE(estimate.readout().value_s == Approx(0.02));
  estimate.correct(S(0.002), S(0.003));  // from now on it follows
  REQUIRE(estimate.readout().value_s == Approx(0.022));
}
