#pragma once
/// Health of an estimate: a state and its reason, published with every estimate.

#include <cstdint>

namespace plumbline {

enum class HealthState : std::uint8_t {
  initializing,  ///< no pose yet
  tracking,      ///< a pose with the usual accuracy
  degraded,      ///< a pose of reduced accuracy
  lost,          ///< no current pose: the last one is held
};

enum class HealthReason : std::uint8_t {
  none,
  few_features,     ///< too few features are tracked
  few_inliers,      ///< most tracked features do not fit one rigid motion
  no_depth,         ///< the depth image has no measurement where the features are
  unconstrained,    ///< the observed features do not determine the pose
  aligning,         ///< scale, gravity and biases are not determined yet, see InitReport
  scale_uncertain,  ///< a metric pose whose scale has a large sigma
  no_imu_data,      ///< IMU samples are missing
  imu_only,         ///< visual outage: the pose is propagated by the IMU alone
  imu_disagrees,    ///< IMU and images contradict each other: time offset, extrinsics or noise are wrong
  images_repeat,    ///< the image is identical to the previous one while the body moves
  imu_saturated,    ///< IMU samples at the full scale of the sensor
  map_only,         ///< nothing is tracked: the map recognizes the place of this frame alone
};

struct Health {
  HealthState state = HealthState::initializing;
  HealthReason reason = HealthReason::none;
};

constexpr const char* name_of(HealthState state) {
  switch (state) {
    case HealthState::initializing: return "initializing";
    case HealthState::tracking: return "tracking";
    case HealthState::degraded: return "degraded";
    case HealthState::lost: return "lost";
  }
  return "unknown";
}

constexpr const char* name_of(HealthReason reason) {
  switch (reason) {
    case HealthReason::none: return "none";
    case HealthReason::few_features: return "few features";
    case HealthReason::few_inliers: return "few inliers";
    case HealthReason::no_depth: return "no depth";
    case HealthReason::unconstrained: return "unconstrained";
    case HealthReason::aligning: return "aligning";
    case HealthReason::scale_uncertain: return "scale uncertain";
    case HealthReason::no_imu_data: return "no IMU data";
    case HealthReason::imu_only: return "IMU only";
    case HealthReason::imu_disagrees: return "IMU disagrees";
    case HealthReason::images_repeat: return "images repeat";
    case HealthReason::imu_saturated: return "IMU saturated";
    case HealthReason::map_only: return "map only";
  }
  return "unknown";
}

}  // namespace plumbline
