#include "plumbline/state/tracking_state.hpp"

#include <string>

#include "catch.hpp"

using namespace plumbline;
using enum TrackingState;
using enum TrackingEvent;

namespace {

constexpr TrackingState all_states[] = {uninitialized, initializing, visual_only, nominal, outage, lost};
constexpr TrackingEvent all_events[] = {first_view,
                                        landmarks_located,
                                        initialized,
                                        pose_found,
                                        no_pose,
                                        image_unusable,
                                        imu_vision_inconsistent,
                                        outage_too_long,
                                        initialization_rejected,
                                        relocalized,
                                        reset_requested};
static_assert(std::size(all_states) == tracking_states && std::size(all_events) == tracking_events);

/// What each pair is to lead to, written by state; pairs that are not named leave the state as it is.
TrackingState expected(TrackingState state, TrackingEvent event) {
  if (event == relocalized) return nominal;
  const bool is_up = state == nominal || state == outage;
  switch (event) {
    case first_view: return is_up ? state : initializing;
    case landmarks_located: return state == initializing || state == visual_only ? visual_only : state;
    case initialized: return state == initializing || state == visual_only ? nominal : state;
    case pose_found: return state == outage ? nominal : state;
    case no_pose: return state == nominal ? outage : state == visual_only ? uninitialized : state;
    case image_unusable: return state == nominal ? outage : state == initializing ? uninitialized : state;
    case imu_vision_inconsistent: return state == nominal ? outage : state == visual_only ? uninitialized : state;
    case outage_too_long:
    case initialization_rejected:
    case reset_requested: return is_up ? lost : state == lost ? lost : uninitialized;
    case relocalized: break;
  }
  return nominal;
}

}  // namespace

TEST_CASE("tracking_state: every pair of state and event has the transition that it should have") {
  for (const TrackingState state : all_states) {
    for (const TrackingEvent event : all_events) {
      CAPTURE(name_of(state), name_of(event));
      CHECK(next_state(state, event) == expected(state, event));
    }
  }
}

TEST_CASE("tracking_state: an initialized estimator is reset through `lost` alone, and every reset is counted once") {
  for (const TrackingState state : {nominal, outage}) {
    for (const TrackingEvent event : all_events) CHECK(next_state(state, event) != uninitialized);
  }
  TrackingStatus status;
  CHECK_FALSE(status.has_first_view());
  status.handle(first_view);
  CHECK(status.has_first_view());
  CHECK_FALSE(status.has_landmarks());
  status.handle(landmarks_located);
  CHECK(status.has_landmarks());
  status.handle(initialized);
  status.handle(no_pose);
  CHECK(status.state() == outage);
  CHECK(status.has_landmarks());
  status.handle(outage_too_long);
  status.handle(outage_too_long);
  CHECK(status.state() == lost);
  CHECK(status.resets() == 1);
  status.handle(first_view);
  CHECK(status.state() == initializing);
  CHECK(status.resets() == 1);
}

TEST_CASE("tracking_state: a rejected alignment is no reset, a rejected scale is one") {
  TrackingStatus status;
  for (const TrackingEvent event : {first_view, landmarks_located, initialization_rejected}) status.handle(event);
  CHECK(status.state() == uninitialized);
  CHECK(status.resets() == 0);
  for (const TrackingEvent event : {first_view, landmarks_located, initialized, initialization_rejected})
    status.handle(event);
  CHECK(status.state() == lost);
  CHECK(status.resets() == 1);
}

TEST_CASE("tracking_state: names are given and differ") {
  for (const TrackingState a : all_states) {
    CHECK(std::string(name_of(a)) != "unknown");
    for (const TrackingState b : all_states) CHECK((a == b) == (std::string(name_of(a)) == name_of(b)));
  }
  for (const TrackingEvent a : all_events) {
    CHECK(std::string(name_of(a)) != "unknown");
    for (const TrackingEvent b : all_events) CHECK((a == b) == (std::string(name_of(a)) == name_of(b)));
  }
}
