#include "plumbline/backend/time_offset_prior.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("time_offset_prior: its gradient is that of its cost") {
  const TimeOffsetPrior prior({}, 0);
  for (const double e : {0.0, 1e-4, -2e-3, 0.015, 0.1}) {
    const double step = 1e-8, slope = (prior.cost(e + step) - prior.cost(e - step)) / (2 * step);
    CAPTURE(e);
    CHECK(prior.information(e) * e == Approx(slope).epsilon(1e-5).margin(1e-3));
  }
}

TEST_CASE("time_offset_prior: a calibration has its sigma, and little weight where it is wrong") {
  const TimeOffsetOptions options;
  const TimeOffsetPrior calibrated(options, 1e-5), found(options, 4e-3);
  CHECK(calibrated.information(0) == Approx(1 / (options.sigma_s * options.sigma_s)));
  CHECK(found.information(0) == Approx(1 / (4e-3 * 4e-3)));
  CHECK(calibrated.information(0.05) < 0.01 * calibrated.information(0));
}
