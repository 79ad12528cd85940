#include "plumbline/estimator/clock.hpp"

#include "catch.hpp"

using namespace plumbline;

namespace {
/// Half a second passes with every look at it.
struct Counting {
  static inline double t = 0;
  static double now() { return t += 0.5; }
};
struct WithoutNow {};
}  // namespace

TEST_CASE("clock: a lap is the time since the last one") {
  Stopwatch<Counting> watch;
  CHECK(watch.lap() == 0.5);
  (void)Counting::now();
  CHECK(watch.lap() == 1);
  CHECK(watch.lap() == 0.5);
}

TEST_CASE("clock: without a clock no time passes") {
  STATIC_REQUIRE((Clock<Counting> && Clock<NoClock> && !Clock<WithoutNow>));
  Stopwatch<NoClock> watch;
  CHECK(watch.lap() == 0);
  CHECK(FrameTiming{.pyramid = 1, .align = 2, .follow = 4, .estimate = 8, .map = 16}.track() == 7);
}
