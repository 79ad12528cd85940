#include "plumbline/estimator/publisher.hpp"

#include "catch.hpp"
#include "plumbline/state/navigation.hpp"

using namespace plumbline;
using enum TrackingState;

namespace {

struct RigState {
  double time_offset_s() const { return 0.01; }
  SE3<double> T_body_cam() const { return SE3<double>({}, {0.1, 0, 0}); }
};

HealthState state_of(TrackingState state, const FrameReport& report, bool was_reset = false, bool converged = true) {
  const Health health = health_of(state, report, was_reset, converged);
  if (health.state != HealthState::tracking && converged) CHECK(health.reason == report.reason);
  return health.state;
}

}  // namespace

TEST_CASE("publisher: health before initialization") {
  const FrameReport waiting{.reason = HealthReason::aligning};
  const FrameReport stationary{.reason = HealthReason::aligning, .has_metric_pose = true};
  for (const TrackingState state : {uninitialized, initializing, visual_only, lost}) {
    CHECK(state_of(state, waiting) == HealthState::initializing);
    CHECK(state_of(state, waiting, /*was_reset=*/true) == HealthState::lost);
    CHECK(state_of(state, stationary) == HealthState::degraded);
    CHECK(state_of(state, stationary, /*was_reset=*/true) == HealthState::degraded);
  }
}

TEST_CASE("publisher: health of a nominal frame") {
  CHECK(state_of(nominal, {}) == HealthState::tracking);
  CHECK(state_of(nominal, {}, /*was_reset=*/true) == HealthState::tracking);
  CHECK(state_of(nominal, {.reason = HealthReason::few_features}) == HealthState::degraded);
  const Health uncertain = health_of(nominal, {}, false, /*is_scale_converged=*/false);
  CHECK(uncertain.state == HealthState::degraded);
  CHECK(uncertain.reason == HealthReason::scale_uncertain);
  // What is known to be wrong comes before what is only uncertain.
  CHECK(health_of(nominal, {.reason = HealthReason::imu_saturated}, false, false).reason ==
        HealthReason::imu_saturated);
}

TEST_CASE("publisher: an outage is degraded as long as it is bridged") {
  CHECK(state_of(outage, {.reason = HealthReason::imu_only, .is_bridged = true}) == HealthState::degraded);
  CHECK(state_of(outage, {.reason = HealthReason::few_features}) == HealthState::lost);
}

TEST_CASE("publisher: the estimate is a copy of the navigation state") {
  Navigation<double, InertialLayout> navigation(WorldFrameUncertainty<double>{});
  NavState<double> x;
  x.T_world_body = SE3<double>({}, {1, 2, 3});
  x.v_world_body = {4, 5, 6};
  navigation.set_state(x);
  navigation.set_covariance(2 * identity<double, 6>());
  navigation.set_time(5);
  TrackingStatus status;
  for (const TrackingEvent event : {TrackingEvent::first_view, TrackingEvent::initialized}) status.handle(event);
  Publisher<double> publisher;
  publisher.publish(navigation, RigState{}, {.tracked = 9}, status, true, /*is_keyframe=*/true);
  const Estimate<double>& estimate = publisher.latest();
  CHECK(estimate.t_ns == 5);
  CHECK(estimate.T_world_body.p() == x.T_world_body.p());
  CHECK(estimate.v_world_body == x.v_world_body);
  CHECK(estimate.covariance == navigation.covariance());
  CHECK(estimate.time_offset_s == 0.01);
  CHECK(estimate.T_body_cam.p().x() == 0.1);
  CHECK(estimate.health.state == HealthState::tracking);
  CHECK(estimate.tracked == 9);
  CHECK(estimate.keyframe);
  CHECK(estimate.resets == 0);
}
