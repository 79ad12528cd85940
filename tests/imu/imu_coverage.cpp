#include "plumbline/imu/imu_coverage.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("imu_coverage: the missing part of two successive times is that of their sum") {
  ImuCoverage a, b;
  CHECK(a.missing() == 1);  // no samples
  a = {.valid = true, .intervals = 3, .duration_s = 0.1, .gap_s = 0.02, .held_s = 0.01};
  CHECK(a.missing() == Approx(0.3));
  b = {.valid = true, .intervals = 4, .duration_s = 0.3, .frozen_s = 0.05, .saturated_s = 0.2, .gyro_saturated_s = 0.1};
  a += b;
  CHECK(a.intervals == 7);
  CHECK(a.missing() == Approx(0.08 / 0.4));
  CHECK((a.saturated_s == 0.2 && a.gyro_saturated_s == 0.1));
  a += ImuCoverage{};
  CHECK(a.valid);
  b.held_s = 0.3;  // held and frozen at once
  CHECK(b.missing() == 1);
}
