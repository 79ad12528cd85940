#pragma once
/// The published estimate and its health. This is the only header that writes an Estimate or a Health; nothing in the
/// estimator reads them.

#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/tracking_state.hpp"

namespace plumbline {

/// The health of a frame: a function of the tracking state, of what the frame found, and of whether the scale that
/// images and IMU determine has converged.
///
///   before initialization   degraded with a metric pose, else initializing, or lost after a reset
///   nominal                 tracking, or degraded for a reason
///   outage                  degraded while the pose is bridged, then lost
constexpr Health health_of(TrackingState state, const FrameReport& report, bool was_reset, bool is_scale_converged) {
  switch (state) {
    case TrackingState::nominal:
      if (report.reason != HealthReason::none) return {HealthState::degraded, report.reason};
      if (!is_scale_converged) return {HealthState::degraded, HealthReason::scale_uncertain};
      return {HealthState::tracking, HealthReason::none};
    case TrackingState::outage: return {report.is_bridged ? HealthState::degraded : HealthState::lost, report.reason};
    case TrackingState::uninitialized:
    case TrackingState::initializing:
    case TrackingState::visual_only:
    case TrackingState::lost:
      if (report.has_metric_pose) return {HealthState::degraded, report.reason};
      return {was_reset ? HealthState::lost : HealthState::initializing, report.reason};
  }
  return {};
}

template <class S>
class Publisher {
 public:
  const Estimate<S>& latest() const { return estimate_; }

  void publish(const auto& navigation, const auto& rig_state, const FrameReport& report, const TrackingStatus& status,
               bool is_scale_converged, bool is_keyframe) {
    const auto& x = navigation.state();
    estimate_.t_ns = navigation.t_ns();
    estimate_.time_offset_s = rig_state.time_offset_s();
    estimate_.T_body_cam = rig_state.T_body_cam();
    estimate_.T_world_body = x.T_world_body;
    estimate_.covariance = navigation.covariance();
    if constexpr (requires { x.v_world_body; }) {
      estimate_.v_world_body = x.v_world_body;
      estimate_.bias_gyro = x.bias_gyro;
      estimate_.bias_accel = x.bias_accel;
    }
    estimate_.health = health_of(status.state(), report, status.resets() > 0, is_scale_converged);
    estimate_.tracked = report.tracked;
    estimate_.keyframe = is_keyframe;
    estimate_.resets = status.resets();
  }

 private:
  Estimate<S> estimate_;
};

}  // namespace plumbline
