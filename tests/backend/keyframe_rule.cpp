// When a frame becomes a keyframe, and which keyframe goes.
#include "plumbline/backend/keyframe_rule.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
constexpr KeyframeOptions of_mono = default_keyframes<Rig<Mono<Camera>>>();
constexpr KeyframeOptions of_mono_imu = default_keyframes<Rig<Mono<Camera>, Imu>>();
constexpr KeyframeOptions of_rgbd = default_keyframes<Rig<Rgbd<Camera>>>();
constexpr KeyframeOptions of_rgbd_imu = default_keyframes<Rig<Rgbd<Camera>, Imu>>();
static_assert(of_mono.max_motion_rad < of_rgbd.max_motion_rad && of_mono.min_tracked_ratio > of_rgbd.min_tracked_ratio);
static_assert(of_mono_imu.max_motion_rad == of_mono.max_motion_rad);
static_assert(of_rgbd_imu.max_motion_rad < of_rgbd.max_motion_rad);

template <class S>
using Window = FrameWindow<S, VisualLayout, 6>;

/// Frames that look the same way, side by side.
template <class S>
Window<S> side_by_side(std::initializer_list<double> x) {
  Window<S> window;
  TimeNs t_ns = 0;
  for (const double x_k : x) window.insert(t_ns++, {SE3<S>(SO3<S>(), Vec<S, 3>(S(x_k), 0, 0))});
  return window;
}

}  // namespace

TEST_CASE("keyframe_rule: few landmarks are left, or they moved far") {
  const KeyframeRule rule(KeyframeOptions{.min_tracked_ratio = 0.5, .max_motion_rad = 0.15});
  CHECK_FALSE(rule.is_keyframe(100, 100, 0));
  CHECK_FALSE(rule.is_keyframe(50, 100, 0.15));
  CHECK(rule.is_keyframe(49, 100, 0));
  CHECK(rule.is_keyframe(100, 100, 0.151));
  CHECK_FALSE(rule.is_keyframe(120, 0, 0));  // none then: any landmark is more
}

TEMPLATE_TEST_CASE("keyframe_rule: with IMU factors the oldest is dropped", "", float, double) {
  Window<TestType> window = side_by_side<TestType>({0, 0.5, 0.5, 2, 3});
  CHECK(KeyframeRule::leaving(window, TestType(1), true) == 0);
  window.remove(0);
  window.insert(9, {});  // into slot 0, and the newest
  CHECK(KeyframeRule::leaving(window, TestType(1), true) == 1);
}

TEMPLATE_TEST_CASE("keyframe_rule: of frames close together one is dropped", "", float, double) {
  using S = TestType;
  // 1 and 2 see the same; 1 is a little farther from the newest.
  CHECK(KeyframeRule::leaving(side_by_side<S>({0, 1, 1.02, 2, 3}), S(1), false) == 1);
  CHECK(KeyframeRule::leaving(side_by_side<S>({0, 1.02, 1, 2, 3}), S(1), false) == 2);
}

TEMPLATE_TEST_CASE("keyframe_rule: of frames evenly spread an inner one, far from the newest, is dropped", "", float,
                   double) {
  using S = TestType;
  const int slot = KeyframeRule::leaving(side_by_side<S>({0, 1, 2, 3, 4}), S(1), false);
  CHECK(slot == 1);  // as crowded as 2, and farther from the newest; 0 has neighbors on one side alone
}

TEMPLATE_TEST_CASE("keyframe_rule: the two newest stay, however close", "", float, double) {
  using S = TestType;
  const int slot = KeyframeRule::leaving(side_by_side<S>({0, 1, 2, 3, 3}), S(1), false);
  CHECK(slot >= 0);
  CHECK(slot < 3);
  // By age, not by slot.
  Window<S> window = side_by_side<S>({7, 1, 3, 3.01});
  window.remove(0);
  window.insert(9, {SE3<S>(SO3<S>(), Vec<S, 3>(S(3.02), 0, 0))});  // slot 0
  CHECK(KeyframeRule::leaving(window, S(1), false) != 0);
  CHECK(KeyframeRule::leaving(window, S(1), false) != 3);
}

TEMPLATE_TEST_CASE("keyframe_rule: distances count in units of the scene's depth, rotations as they are", "", float,
                   double) {
  using S = TestType;
  Window<S> window;
  const auto insert = [&](double x, double yaw) {
    window.insert(0, {SE3<S>(SO3<S>::exp({0, S(yaw), 0}), Vec<S, 3>(S(x), 0, 0))});
  };
  insert(0, 0);
  insert(0.3, 0);  // close to 0 in a deep scene
  insert(2, 1);
  insert(2, 1.2);  // close to 2 in a scene that is not
  insert(3, 0.5);
  insert(4, 0.5);
  const int deep = KeyframeRule::leaving(window, S(30), false), near = KeyframeRule::leaving(window, S(0.3), false);
  CAPTURE(deep, near);
  CHECK((deep == 0 || deep == 1));
  CHECK((near == 2 || near == 3));
}
