#pragma once
/// What an estimator with an IMU is made of beside its images: readings, the latest state, rest.
///                                                                                docs/math/inertial_window.md

#include "plumbline/estimator/imu_intake.hpp"
#include "plumbline/estimator/visual_tracking.hpp"
#include "plumbline/imu/standstill.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy>
class InertialTracking : public VisualTracking<Sensors, FeatureSet, BackendPolicy> {
  using Base = VisualTracking<Sensors, FeatureSet, BackendPolicy>;

 public:
  using typename Base::Options;
  using typename Base::S;

  const ImuBuffer<>& imu() const { return imu_.buffer(); }
  /// Whether the body stands still, as image and IMU have it.
  bool at_rest() const { return at_rest_; }

 protected:
  using Base::estimate_;
  using Base::features_;
  using Base::keyframe_slot_;
  using Base::options_;

  InertialTracking(const Sensors& rig, const Options& options)
      : Base(rig, options),
        imu_(rig.imu, inflated(rig.imu.noise, options.fusion)),
        since_keyframe_(imu_.since(state_)) {}

  /// The readings since the last frame.
  void integrate(TimeNs t_ns) {
    imu_.integrate(t_ns, state_);
    since_keyframe_.append(imu_.since_frame());
    blind_since_keyframe_ = blind_since_keyframe_ || imu_.blind();
    S duration = imu_.since_frame().increment().duration;
    if (!(duration > S(0))) duration = S(seconds_between(estimate_.t_ns, t_ns));
    body_rate_ = imu_.since_frame().increment().delta.dR.log() / duration;
  }

  int feature_count() const {
    int n = 0;
    features_.for_each([&](const auto& map) {
      for (const auto& landmark : map.landmarks()) n += landmark.current.valid;
    });
    return n;
  }

  void adopt_keyframe(int slot) {
    keyframe_slot_ = slot;
    this->tracked_at_keyframe_ = this->tracked_count();
    since_keyframe_ = imu_.since(state_);
    blind_since_keyframe_ = false;
    estimate_.keyframe = true;
  }
  void adopt_state(int slot) { state_ = this->backend_.state(slot); }

  /// Nothing moved since the last keyframe, by image and IMU. Rest is left less easily than it is entered.
  bool finds_rest(TimeNs t_ns) {
    StandstillOptions options = options_.fusion.standstill;
    const double slack = at_rest_ ? options_.fusion.rest_hysteresis : 1;
    options.gyro_spread *= slack;
    options.accel_spread *= slack;
    if (!(this->mean_motion_px(keyframe_slot_) < slack * options_.fusion.rest_motion_px)) return false;
    rest_ = standstill(imu_.buffer(), imu_.time_of(t_ns), options);
    return rest_.at_rest();
  }

  /// The latest state as the estimate of the frame.
  void publish(TimeNs t_ns) {
    estimate_.t_ns = t_ns;
    estimate_.T_world_body = state_.T_world_body;
    estimate_.v_world_body = state_.v_world_body;
    estimate_.bias_gyro = state_.bias_gyro;
    estimate_.bias_accel = state_.bias_accel;
    estimate_.keyframe = false;
    estimate_.tracked = this->tracked_count();
    estimate_.health = this->health_of_tracking();
    if (this->backend_.inertial().disagreement(this->backend_.window()) > options_.fusion.max_disagreement)
      estimate_.health = {HealthState::degraded, HealthReason::imu_disagrees};
    if (imu_.coverage().saturated_s > 0) estimate_.health = {HealthState::degraded, HealthReason::imu_saturated};
    if (imu_.missing()) estimate_.health = {HealthState::degraded, HealthReason::no_imu_data};
    Mat<S, 6, 6> covariance;
    if (this->backend_.newest_covariance(covariance)) estimate_.covariance = covariance;
  }

  ImuIntake<S> imu_;
  NavState<S> state_;  ///< of the latest frame
  Preintegration<S> since_keyframe_;
  bool blind_since_keyframe_ = false;
  Vec<S, 3> body_rate_ = Vec<S, 3>::Zero();
  StandstillReport rest_;
  bool at_rest_ = false;
  TimeNs good_ns_ = 0;  ///< of the last frame whose image was of use

 private:
  static ImuNoise inflated(ImuNoise noise, const FusionOptions& options) {
    noise.gyro_density *= options.gyro_inflation;
    noise.accel_density *= options.accel_inflation;
    noise.gyro_walk *= options.walk_inflation;
    noise.accel_walk *= options.walk_inflation;
    return noise;
  }
};

}  // namespace plumbline
