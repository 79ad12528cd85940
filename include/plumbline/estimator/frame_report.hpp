#pragma once
/// What the processing of one frame found, as the publisher and the tracking state need it.

#include "plumbline/state/health.hpp"

namespace plumbline {

struct FrameReport {
  /// Located landmarks that support the pose.
  int tracked = 0;
  /// Why there is no pose, or what limits it; `none` for a good one.
  HealthReason reason = HealthReason::none;
  /// Whether images and IMU contradict each other, whatever the reason is.
  bool is_inconsistent = false;
  /// Before initialization: there is a pose nevertheless, metric of a stationary body or of an uncertain scale, or that
  /// of the map.
  bool has_metric_pose = false;
  /// In an outage: the pose is held or propagated, and for no longer than the estimator bridges; or it is the map's.
  bool is_bridged = false;
};

}  // namespace plumbline
