#include "plumbline/imu/imu_counts.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/imu/imu_buffer.hpp"

using namespace plumbline;

TEST_CASE("imu_counts: each sample is counted by what became of it") {
  constexpr TimeNs ms = 1'000'000;
  ImuBuffer<8> buffer;
  const auto add = [&](TimeNs t, double x) { return bool(buffer.add({t, {x, 0, 0}, {0, 0, 9.81}})); };
  CHECK(add(10 * ms, 1));
  CHECK(add(20 * ms, 2));
  CHECK(add(15 * ms, 3));
  CHECK_FALSE(add(15 * ms, 4));
  CHECK_FALSE(add(30 * ms, std::numeric_limits<double>::quiet_NaN()));
  buffer.mark_used(20 * ms);
  CHECK_FALSE(add(12 * ms, 5));
  CHECK(add(5'000 * ms, 6));
  const ImuCounts& counts = buffer.counts();
  CHECK(counts.accepted == 4);
  CHECK((counts.reordered == 1 && counts.repeated == 1 && counts.late == 1));
  CHECK((counts.not_finite == 1 && counts.clock_jumps == 1));
  CHECK((counts.saturated == 0 && counts.frozen == 0));
}
