// When a frame becomes a keyframe.
#include "plumbline/backend/keyframe_rule.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

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

}  // namespace

TEST_CASE("keyframe_rule: few landmarks are left, or they moved far") {
  const KeyframeRule rule(KeyframeOptions{.min_tracked_ratio = 0.5, .max_motion_rad = 0.15});
  CHECK_FALSE(rule.is_keyframe(100, 100, 0));
  CHECK_FALSE(rule.is_keyframe(50, 100, 0.15));
  CHECK(rule.is_keyframe(49, 100, 0));
  CHECK(rule.is_keyframe(100, 100, 0.151));
  CHECK_FALSE(rule.is_keyframe(120, 0, 0));  // none then: any landmark is more
}
