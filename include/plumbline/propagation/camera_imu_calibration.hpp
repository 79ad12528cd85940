#pragma once
/// Extrinsics and time offset that are in force: found by CameraImuFilter before initialization, by the window
/// afterwards, and applied to the rig from the next frame on.                     docs/math/camera_imu.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/camera_time_offset.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

template <class S>
class CameraImuCalibration {
 public:
  CameraImuCalibration(const auto& rig, const CameraImuOptions& options)
      : T_body_cam_calibrated_(rig.T_body_cam()), filter_(options), time_offset_(rig.imu.camera_time_offset_s) {}

  /// Applies what has been estimated, to the samples of the IMU as well. `in_window`: by the window, else by the
  /// filter. A reset discards what the window has estimated of it. Returns the time offset [s].
  double apply(auto& rig, const auto& window, bool in_window, double max_step_s, ImuIntegrator<S>& imu) {
    const SE3<S>& T_body_cam = window.T_body_cam(T_body_cam_calibrated_);
    const SO3<S> rotation_step = T_body_cam.rotation() * rig.T_body_cam().rotation().inverse();
    filter_.rotate_extrinsics(cast_to<double>(rotation_step.log()));
    rig.set_T_body_cam(T_body_cam);
    time_offset_.calibrate(filter_, window, in_window, max_step_s);
    rig.set_time_offset(time_offset_.offset_s());
    imu.set_camera_time_offset(time_offset_.offset_s());
    return time_offset_.offset_s();
  }
  /// Takes the time offset of the window, at most max_step_s [s] of it.
  void adopt_time_offset(const auto& window, double max_step_s) {
    time_offset_.calibrate(filter_, window, /*in_window=*/true, max_step_s);
  }

  /// Propagates the filter by the samples since the last frame.
  void propagate(const ImuIntegrator<S>& imu) {
    if (imu.is_missing()) filter_.reset_world();
    filter_.propagate(imu.since_frame().increment());
  }
  /// Updates the filter with the orientation R of the frame by its images, and its covariance.
  void update(const SO3<S>& R, const Mat<S, 6, 6>& covariance, const Vec<S, 3>& bias_gyro,
              const ImuIntegrator<S>& imu) {
    if (imu.since_frame().empty()) return;
    const Vec<S, 3> rate = imu.since_frame().intervals().back().mean_gyro() - bias_gyro;
    filter_.update(R.template cast<double>(), cast_to<double>(block<3, 3>(covariance, 0, 0)), cast_to<double>(rate));
  }
  /// A new world frame; corrections of the time offset by the window are taken back.
  void restart() {
    time_offset_.reset_window_correction(filter_);
    filter_.reset_world();
  }
  /// The window estimates from now on.
  void set_initialized() {
    filter_.reset_extrinsics();
    filter_.reset_world();
  }

  const CameraImuFilter& filter() const { return filter_; }
  const CameraTimeOffset<S>& time_offset() const { return time_offset_; }
  CameraTimeOffset<S>& time_offset() { return time_offset_; }
  /// The time offset as prior of the window. `converged_sigma_s`: sigma of the filter below which the offset in use is
  /// accepted even if the filter finds an error of more than one sigma [s].
  TimeOffsetEstimate estimate(bool is_fixed, double converged_sigma_s) const {
    return {time_offset_.offset_s(), filter_.is_time_offset_wrong() ? filter_.time_offset_sigma() : 0, is_fixed,
            !filter_.accepts_time_offset(converged_sigma_s)};
  }

 private:
  SE3<S> T_body_cam_calibrated_;
  CameraImuFilter filter_;
  CameraTimeOffset<S> time_offset_;
};

}  // namespace plumbline
