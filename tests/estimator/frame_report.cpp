#include "plumbline/estimator/frame_report.hpp"

#include "catch.hpp"
#include "plumbline/estimator/publisher.hpp"

using namespace plumbline;

TEST_CASE("frame_report: a frame of which nothing is known is lost in an outage, and no reason degrades a good one") {
  const FrameReport nothing;
  CHECK(health_of(TrackingState::outage, nothing, false, true).state == HealthState::lost);
  CHECK(health_of(TrackingState::initializing, nothing, false, true).state == HealthState::initializing);
  CHECK(health_of(TrackingState::nominal, nothing, false, true).state == HealthState::tracking);
  CHECK(nothing.tracked == 0);
  CHECK_FALSE(nothing.is_inconsistent);
}
