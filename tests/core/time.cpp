#include "plumbline/core/time.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("time: a nanosecond survives at today's epoch") {
  const TimeNs from = 1403636579763555584, to = from + 1;
  CHECK(seconds_between(from, to) == 1e-9);
  CHECK(seconds_between(to, from) == -1e-9);
  CHECK(seconds_between(from, from + 50'000'000) == Approx(0.05).epsilon(1e-15));
}
