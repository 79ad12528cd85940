#pragma once
/// Health is part of every estimate, so that a robot can act on it.

#include <cstdint>

namespace plumbline {

enum class HealthState : std::uint8_t {
  initializing,  ///< no pose yet
  tracking,      ///< as good as it gets
  degraded,      ///< a pose, but with little to support it
  lost,          ///< the pose is the last one known
};

enum class HealthReason : std::uint8_t {
  none,
  few_features,     ///< the images show little that can be tracked
  few_inliers,      ///< most of what is tracked does not fit one rigid motion
  no_depth,         ///< the depth image has no measurement where the features are
  unconstrained,    ///< the features seen do not determine the pose
  aligning,         ///< vision works; scale, gravity and biases are not known yet, see InitReport
  scale_uncertain,  ///< a pose, but its metres are a first guess
  no_imu_data,      ///< inertial samples are missing
  coasting,         ///< the pose is that of the IMU alone
  imu_disagrees,    ///< readings and images contradict each other: clock, extrinsics or noise
  images_repeat,    ///< the same picture again while the body moves
  imu_saturated,    ///< readings at the sensor's full scale
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
    case HealthReason::coasting: return "coasting";
    case HealthReason::imu_disagrees: return "IMU disagrees";
    case HealthReason::images_repeat: return "images repeat";
    case HealthReason::imu_saturated: return "IMU saturated";
  }
  return "unknown";
}

}  // namespace plumbline
