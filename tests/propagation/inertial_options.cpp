#include "plumbline/propagation/inertial_options.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("inertial_options: the consensus gate is below the innovation gate, and stationarity has a hysteresis") {
  const InertialOptions options;
  CHECK(options.consensus_gate < options.innovation_gate);
  CHECK(options.velocity_inflation >= 1);
  CHECK(options.stationary_hysteresis > 1);
  CHECK(options.rate_window_s < options.gyro_check.rate_error_s);
}
