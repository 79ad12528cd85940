#pragma once
/// Detector of a body at rest: its IMU samples are those of a stationary body, and its landmarks stay where they were
/// in the image of the last keyframe. The limits have hysteresis.                 docs/math/inertial_window.md
/// Uniform motion in a straight line has the samples of a body at rest: the images decide.

#include "plumbline/core/time.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/stationarity.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/propagation/inertial_options.hpp"

namespace plumbline {

template <class S>
class StationarityDetector {
 public:
  /// Decides from the samples up to the image at t_ns, and the mean motion of the landmarks since the keyframe [px].
  bool detect(const ImuIntegrator<S>& imu, TimeNs t_ns, double motion_px, const InertialOptions& options) {
    const double scale = is_stationary_ ? options.stationary_hysteresis : 1;
    return is_stationary_ = is_imu_stationary(imu, t_ns, options) && motion_px < scale * options.stationary_motion_px;
  }
  /// Without images: a body at rest stays so as long as its IMU is stationary.
  void keep(const ImuIntegrator<S>& imu, TimeNs t_ns, const InertialOptions& options) {
    is_stationary_ = is_stationary_ && is_imu_stationary(imu, t_ns, options);
  }
  /// Whether the IMU is stationary up to the image at t_ns.
  bool is_imu_stationary(const ImuIntegrator<S>& imu, TimeNs t_ns, const InertialOptions& options) {
    StationarityOptions limits = options.stationarity;
    const double scale = is_stationary_ ? options.stationary_hysteresis : 1;
    limits.gyro_spread *= scale;
    limits.accel_spread *= scale;
    report_ = stationarity(imu.buffer(), imu.time_of(t_ns), limits, options.gravity);
    return report_.is_stationary();
  }

  bool is_stationary() const { return is_stationary_; }
  /// Whether the IMU was stationary when it was looked at last.
  bool was_imu_stationary() const { return report_.is_stationary(); }
  /// The stationary state: tilt and biases by the IMU, velocity zero, at the origin of an upright world.
  NavState<S> state(double gravity) const { return stationary_state<S>(report_, gravity); }

 private:
  StationarityReport report_;
  bool is_stationary_ = false;
};

}  // namespace plumbline
