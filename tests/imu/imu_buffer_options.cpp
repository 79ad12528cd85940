#include "plumbline/imu/imu_buffer_options.hpp"

#include "catch.hpp"
#include "plumbline/imu/imu_buffer.hpp"

using namespace plumbline;

TEST_CASE("imu_buffer_options: full scale, repetitions and gaps are those of the options") {
  constexpr TimeNs ms = 1'000'000;
  ImuBufferOptions options;
  options.gyro_full_scale = 2;
  options.frozen_samples = 3;
  options.gap_s = 0.015;
  ImuBuffer<16> buffer(options);
  CHECK(buffer.add({0, {2.5, 0, 0}, {0, 0, 9.81}})->saturated);
  CHECK(buffer[0].gyro.x() == 2);
  CHECK_FALSE(buffer.add({10 * ms, {1, 0, 0}, {0, 0, 9.81}})->frozen);
  CHECK_FALSE(buffer.add({20 * ms, {1, 0, 0}, {0, 0, 9.81}})->frozen);
  CHECK_FALSE(buffer.add({30 * ms, {1, 0, 0}, {0, 0, 9.81}})->frozen);
  CHECK(buffer.add({40 * ms, {1, 0, 0}, {0, 0, 9.81}})->frozen);
  CHECK(buffer.add({60 * ms, {1.1, 0, 0}, {0, 0, 9.81}}));
  const auto nothing = [](const ImuInterval<double>&) {};
  CHECK(buffer.for_each_interval(40 * ms, 60 * ms, nothing).gap_s == Approx(0.02));
  CHECK(buffer.for_each_interval(10 * ms, 20 * ms, nothing).gap_s == 0);
}
