#include "plumbline/estimator/frame_tracker.hpp"

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

TEST_CASE("frame_tracker: the time without a usable image, and after which time rotation is unknown") {
  const SmallParts parts;
  auto& tracker = *parts.tracker;
  constexpr TimeNs ms = 1'000'000;
  tracker.set_usable(1000 * ms);
  CHECK(tracker.outage_s(1150 * ms) == Approx(0.15));
  CHECK_FALSE(tracker.is_after_gap(1150 * ms));
  CHECK(tracker.is_after_gap(1000 * ms + TimeNs(1.01e9 * parts.options.recovery.gap_s)));
  tracker.set_usable(2000 * ms);
  CHECK_FALSE(tracker.is_after_gap(2000 * ms));
}

TEST_CASE("frame_tracker: features of a moved image give the pose of the camera that moved") {
  SmallParts parts;
  auto& window = *parts.window;
  auto& tracker = *parts.tracker;
  parts.draw(0);
  const auto first = parts.view(1);
  const int slot = window.reset(first, {}, tracker, parts.rig_state);
  window.adopt_keyframe(first, slot, tracker, parts.propagation, parts.navigation);
  tracker.set_usable(1);
  constexpr int shift_px = 4;
  parts.draw(shift_px);
  auto view = parts.view(50'000'000);
  const SmallParts::Tracker::Predicted predicted{{}, {}};
  SE3<double> T;
  Mat<double, 6, 6> covariance;
  REQUIRE(tracker.follow(view, predicted, parts.propagation, window.frames(), window.landmarks(), T) ==
          HealthReason::none);
  REQUIRE(tracker.find_pose(view, predicted, parts.propagation, window.frames(), window.landmarks(), slot, 0, T,
                            covariance) == HealthReason::none);
  CHECK(T.p().x() == Approx(shift_px * 2.0 / 130).epsilon(0.05));  // 2 m away, focal length 130 px
  CHECK(std::abs(T.p().z()) < 0.01);
  CHECK(T.rotation().log().norm() < 0.01);
  CHECK(covariance(3, 3) > 0);
  CHECK(tracker.position_noise(covariance)(0, 0) <= covariance(3, 3));
}

TEST_CASE("frame_tracker: an image without features gives no pose, and the reason") {
  SmallParts parts;
  auto& window = *parts.window;
  auto& tracker = *parts.tracker;
  parts.draw(0);
  const auto first = parts.view(1);
  const int slot = window.reset(first, {}, tracker, parts.rig_state);
  window.adopt_keyframe(first, slot, tracker, parts.propagation, parts.navigation);
  parts.gray.fill(0);
  auto view = parts.view(2);
  const SmallParts::Tracker::Predicted predicted{{}, {}};
  SE3<double> T;
  Mat<double, 6, 6> covariance;
  HealthReason failure = tracker.follow(view, predicted, parts.propagation, window.frames(), window.landmarks(), T);
  if (failure == HealthReason::none)
    failure = tracker.find_pose(view, predicted, parts.propagation, window.frames(), window.landmarks(), slot, 0, T,
                                covariance);
  CHECK(failure != HealthReason::none);
}
