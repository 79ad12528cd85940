#include "plumbline/propagation/covariance_growth.hpp"

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("covariance_growth: the parts of any division add up to the growth of the whole time", "", float,
                   double) {
  using S = TestType;
  const CovarianceGrowth<S> growth{.rate_sigma = S(0.3), .speed_sigma = S(0.5), .position_walk = S(0.1)};
  for (const int parts : {1, 3, 40}) {
    Mat<S, 6, 6> P = identity<S, 6>();
    const S total = S(2), dt = total / S(parts);
    for (int k = 1; k <= parts; ++k) growth.add_to(P, S(k) * dt, dt);
    CHECK(P(1, 1) == Approx(1 + 0.3 * 0.3 * 4).epsilon(1e-5));
    CHECK(P(5, 5) == Approx(1 + 0.5 * 0.5 * 4 + 0.1 * 0.1 * 2).epsilon(1e-5));
    CHECK(P(0, 3) == S(0));
  }
}

TEST_CASE("covariance_growth: an error that is zero adds nothing") {
  const CovarianceGrowth<double> still;
  CHECK(still.rotation_variance(3, 0.1) == 0);
  CHECK(still.position_variance(3, 0.1) == 0);
}
