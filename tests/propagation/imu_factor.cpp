#include "plumbline/propagation/imu_factor.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("imu_factor: the first frame of a window has none, and its samples are empty") {
  const ImuFactor<float> none;
  CHECK(none.previous == -1);
  CHECK(none.samples.empty());
  CHECK_FALSE((none.is_stationary || none.jumped || none.is_accel_suspect));
  CHECK(none.begin.shift(0.5).delay == 0.5f);
}
