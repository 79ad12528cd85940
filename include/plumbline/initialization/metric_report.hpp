#pragma once
/// Metric poses that are reported before the initialization is complete: that of a stationary body, and poses up to
/// scale by the present estimate of the scale.                                   docs/concepts/initialization.md

#include "plumbline/state/health.hpp"

namespace plumbline {

/// Reports the latest pose in meters by the scale of `initializer`, if there is one. `pose`: a DeadReckonedPose, which
/// may be more accurate; `on`: the components of the estimator.
void report_up_to_scale(auto& pose, const auto& initializer, auto&& on) {
  if (!initializer.has_estimate()) return;
  if (!pose.apply_up_to_scale(initializer, on.window.frames().latest().T_world_body, on.rig_state.T_body_cam(),
                              on.navigation))
    return;
  on.report.has_metric_pose = true;
  on.report.reason = HealthReason::scale_uncertain;
}

/// Reports the pose of a body at rest: tilt and biases by the IMU.
void report_stationary(auto& pose, const auto& initializer, auto&& on) {
  pose.apply_stationary(on.propagation.stationary_state(), initializer.options().accel_bias_sigma, on.window.frames(),
                        on.navigation);
  on.report.has_metric_pose = true;
  on.report.reason = HealthReason::aligning;
}

}  // namespace plumbline
