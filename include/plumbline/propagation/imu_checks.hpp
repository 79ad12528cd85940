#pragma once
/// Consistency of IMU and images: jumps of the gyroscope bias, errors of the accelerometer, and IMU factors that the
/// window does not satisfy.                                                       docs/math/inertial_window.md

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/accelerometer_check.hpp"
#include "plumbline/propagation/gyroscope_check.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/propagation/inertial_options.hpp"
#include "plumbline/propagation/samples_since_keyframe.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

template <class S>
class ImuChecks {
 public:
  using Covariance = Mat<S, 6, 6>;

  explicit ImuChecks(const InertialOptions& options) : gyro_(options.gyro_check), accel_(options.accel_check) {}

  void advance(S dt) { gyro_.advance(dt); }
  /// The next frame does not follow the last one.
  void interrupt() { accel_.interrupt(); }
  /// A new world, whose images are not compared with earlier samples of the accelerometer.
  void restart(const AccelerometerCheckOptions& options) { accel_ = AccelerometerCheck<S>(options); }
  void begin_update() { jump_rotation_ = S(0); }

  /// Corrects gyroscope bias and rotation of x when the bias has jumped, T the pose by the images after dt [s]:
  ///   d = log(R_predicted^T R_images) = -(b - b_predicted) dt                  docs/math/inertial_window.md (1c)
  bool detect_jump(NavState<S>& x, const SE3<S>& T, const Covariance& covariance, S dt) {
    const Vec<S, 3> d = (x.T_world_body.rotation().inverse() * T.rotation()).log();
    if (!gyro_.update(d, (covariance(0, 0) + covariance(1, 1) + covariance(2, 2)) / S(3), dt)) return false;
    jump_rotation_ = gyro_.gyro_jump_rotation();
    x.bias_gyro -= gyro_.rate_error();
    x.T_world_body = T;
    gyro_.reset_after_jump();
    return true;
  }
  /// Upper bound of the rotation error of the frames up to this one by a gyroscope bias jump [rad], else 0.
  S jump_rotation() const { return jump_rotation_; }

  /// Updates the accelerometer check with a frame that its images place at T; from `before` the samples predict
  /// `predicted`. There is no check while images and gyroscope disagree. After a detection the accelerometer noise is
  /// inflated, so that images and gyroscope determine the motion.
  void check_accelerometer(const SE3<S>& T, const Covariance& covariance, bool is_stationary, const NavState<S>& before,
                           const NavState<S>& predicted, const auto& view, const InertialOptions& options,
                           ImuIntegrator<S>& imu, SamplesSinceKeyframe<S>& since_keyframe) {
    const ImuCoverage& coverage = imu.coverage();
    const bool usable =
        coverage.missing() == 0 && coverage.saturated_s == 0 && !is_stationary && !gyro_.has_recent_jump();
    if (!usable) accel_.interrupt();
    if (!usable || gyro_.is_suspect()) return;
    const bool was_suspect = accel_.is_suspect();
    const S sigma = std::sqrt((covariance(3, 3) + covariance(4, 4) + covariance(5, 5)) / S(3));
    accel_.update(T.p(), sigma, view.T_world_previous.p(), before, predicted, view.dt, factors_disagree_);
    const S noise = accel_.is_suspect() ? S(options.suspect_accel_sigma) : S(0);
    imu.inflate_accelerometer_noise(noise);
    if (noise > S(0) && !was_suspect) since_keyframe.distrust_accelerometer(noise);
  }
  bool is_accel_suspect() const { return accel_.is_suspect(); }
  /// Gate of the pose by the images about the IMU prediction [sigma], wider while the gyroscope is suspect.       (1b)
  double innovation_gate(const InertialOptions& options) const {
    if (gyro_.has_recent_jump()) return options.innovation_gate_after_jump;
    return gyro_.is_suspect() ? suspect_gate_ratio * options.innovation_gate : options.innovation_gate;
  }

  /// The reason for degraded health by the IMU. `disagreement`: of the factors in the window, 0 where it is not solved.
  HealthReason diagnose(double disagreement, const ImuIntegrator<S>& imu, const InertialOptions& options) {
    factors_disagree_ = disagreement > options.max_disagreement;
    if (imu.is_missing()) return HealthReason::no_imu_data;
    // Clipping at a full scale near gravity has the effect of a bias on later samples.
    const bool saturates_at_gravity = imu.buffer().accel_full_scale() < options.min_full_scale * options.gravity;
    if (imu.coverage().saturated_s > 0 || saturates_at_gravity) return HealthReason::imu_saturated;
    return is_inconsistent() ? HealthReason::imu_disagrees : HealthReason::none;
  }
  /// Whether images and IMU are inconsistent, by the last diagnosis, also where its reason is another one.
  bool is_inconsistent() const { return factors_disagree_ || gyro_.has_recent_jump() || accel_.is_suspect(); }

 private:
  /// Of innovation_gate while the gyroscope is suspect; tuned: docs/decisions/014.
  static constexpr double suspect_gate_ratio = 2;

  GyroscopeCheck<S> gyro_;
  S jump_rotation_ = S(0);  ///< of this frame [rad]
  AccelerometerCheck<S> accel_;
  bool factors_disagree_ = false;
};

}  // namespace plumbline
