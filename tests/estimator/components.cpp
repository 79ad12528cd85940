#include "plumbline/estimator/components.hpp"

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;

TEST_CASE("components: they are referred to, not copied") {
  test::SmallParts parts;
  const auto on = parts.components();
  on.report.tracked = 7;
  on.status.handle(TrackingEvent::first_view);
  on.navigation.set_time(9);
  CHECK(parts.report.tracked == 7);
  CHECK(parts.status.state() == TrackingState::initializing);
  CHECK(parts.navigation.t_ns() == 9);
  CHECK(&on.window == parts.window.get());
}
