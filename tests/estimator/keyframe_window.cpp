#include "plumbline/estimator/keyframe_window.hpp"

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

TEST_CASE("keyframe_window: a reset leaves one keyframe, whose landmarks are located by depth") {
  SmallParts parts;
  parts.draw(0);
  for (int k = 0; k < 2; ++k) {  // the second one removes what the first one left
    const auto view = parts.view(1 + k);
    const SE3<double> T({}, {1.0 + k, 2, 3});
    const int slot = parts.window->reset(view, {T}, *parts.tracker, parts.rig_state);
    CHECK_FALSE(parts.window->is_latest_keyframe());
    parts.window->adopt_keyframe(view, slot, *parts.tracker, parts.propagation, parts.navigation);
    CHECK(parts.window->is_latest_keyframe());
    CHECK(parts.window->frames().size() == 1);
    CHECK(parts.window->keyframe() == slot);
    CHECK(parts.window->frames().latest().T_world_body.p() == T.p());
    CHECK(parts.navigation.T_world_body().p() == T.p());
    CHECK(parts.window->landmarks().seen_count() > 10);
    CHECK(parts.window->mean_depth() == Approx(2).epsilon(0.1));
  }
}

TEST_CASE("keyframe_window: a frame begins as no keyframe, and knows whether the one before it was one") {
  SmallParts parts;
  parts.draw(0);
  const auto view = parts.view(1);
  const int slot = parts.window->reset(view, {}, *parts.tracker, parts.rig_state);
  CHECK(parts.window->begin_frame() == SmallParts::Window::none);
  parts.window->adopt_keyframe(view, slot, *parts.tracker, parts.propagation, parts.navigation);
  CHECK(parts.window->begin_frame() == slot);
  CHECK_FALSE(parts.window->is_latest_keyframe());
  CHECK(parts.window->begin_frame() == SmallParts::Window::none);
}

TEST_CASE("keyframe_window: the covariance of a later pose is that of the keyframe, transported, and its own") {
  SmallParts parts;
  parts.draw(0);
  const auto view = parts.view(1);
  const int slot = parts.window->reset(view, {}, *parts.tracker, parts.rig_state);
  parts.window->adopt_keyframe(view, slot, *parts.tracker, parts.propagation, parts.navigation);
  const Mat<double, 6, 6> keyframe = parts.navigation.covariance();
  const Mat<double, 6, 6> relative = 1e-4 * identity<double, 6>();
  CHECK((parts.window->covariance_of({}, relative) - keyframe - relative).norm() < 1e-12);
  // A meter ahead the rotation of the keyframe moves the position sideways.
  const SE3<double> ahead({}, {0, 0, 1});
  const Mat<double, 6, 6> there = parts.window->covariance_of(ahead, zeros<double, 6, 6>());
  CHECK(there(3, 3) == Approx(keyframe(3, 3) + keyframe(1, 1)).epsilon(1e-6));
  CHECK(there(5, 5) == Approx(keyframe(5, 5)).epsilon(1e-6));
}

TEST_CASE("keyframe_window: few landmarks are the reason that limits a pose") {
  SmallParts parts;
  parts.draw(0);
  const auto first = parts.view(1);
  const int slot = parts.window->reset(first, {}, *parts.tracker, parts.rig_state);
  parts.window->adopt_keyframe(first, slot, *parts.tracker, parts.propagation, parts.navigation);
  parts.window->accept_latest(parts.propagation, parts.navigation, parts.report);
  CHECK(parts.report.tracked > 2 * parts.options.pose.min_inliers);
  CHECK(parts.report.reason == HealthReason::none);
  parts.gray.fill(100);
  (void)parts.window->reset(parts.view(2), {}, *parts.tracker, parts.rig_state);
  parts.window->accept_latest(parts.propagation, parts.navigation, parts.report);
  CHECK(parts.report.tracked == 0);
  CHECK(parts.report.reason == HealthReason::few_features);
}
