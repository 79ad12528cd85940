#include "plumbline/motion/inertial_options.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE(
    "inertial_options: what is preferred is nearer than what is excluded, and rest is entered before it is left") {
  const InertialOptions options;
  CHECK(options.max_vote < options.max_innovation);
  CHECK(options.velocity_doubt >= 1);
  CHECK(options.rest_hysteresis > 1);
  CHECK(options.rate_s < options.gyro_check.rate_error_s);
}
