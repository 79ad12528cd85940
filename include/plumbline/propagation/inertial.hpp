#pragma once
/// Propagation of a rig with an IMU: IMU samples predict the next frame and give the IMU factor to the last keyframe.
///                                                                                docs/math/inertial_window.md
/// Before initialization the gyroscope predicts the rotation and the velocity of the images the translation. While the
/// IMU is unusable (samples missing or saturated) images give both.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/propagation/camera_imu_calibration.hpp"
#include "plumbline/propagation/frame_twist.hpp"
#include "plumbline/propagation/imu_checks.hpp"
#include "plumbline/propagation/imu_factors.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/propagation/inertial_options.hpp"
#include "plumbline/propagation/pose_gates.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/propagation/samples_since_keyframe.hpp"
#include "plumbline/propagation/stationarity_detector.hpp"
#include "plumbline/propagation/velocity_uncertainty.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_state.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

template <SensorRig SensorsT>
class Inertial {
 public:
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  using Layout = InertialLayout;
  using State = FrameValue<S, Layout>;
  using Options = InertialOptions;
  template <int Slots>
  using Factors = ImuFactors<S, Slots>;
  using Factor = ImuFactor<S>;
  static constexpr bool has_imu_factors = true;

  Inertial(const Sensors& rig, const Options& options)
      : options_(options),
        gravity_(gravity_in_world<S>(S(options.gravity))),
        imu_(rig.imu, options.inflated(rig.imu.noise)),
        calibration_(rig, options.camera_imu),
        velocity_(options.velocity_sigma),
        checks_(options) {}

  const Options& options() const { return options_; }
  ImuIntegrator<S>& imu() { return imu_; }
  const ImuIntegrator<S>& imu() const { return imu_; }

  /// Applies the estimated extrinsics and time offset from the next frame on. Returns the time offset [s].
  double calibrate(auto& rig, const auto& window) {
    return calibration_.apply(rig, window, initialized_, options_.camera_imu.max_step_s, imu_);
  }
  /// Takes the time offset of the window at once, with or without active factors.
  void adopt_time_offset(const auto& window) {
    calibration_.adopt_time_offset(window, options_.camera_imu.max_correction_s);
  }
  void begin_frame(TimeNs t_ns, const State* latest, S dt) {
    if (latest) {
      imu_.integrate(t_ns, *latest);
      calibration_.propagate(imu_);
      since_keyframe_.append(imu_.since_frame().intervals(), imu_.is_unusable());
      twist_.advance(imu_, latest->bias_gyro, dt, options_.rate_window_s);
      stationarity_.keep(imu_, t_ns, options_);
    }
    calibration_.time_offset().set_gyro(imu_.latest_gyro(options_.rate_window_s));
    checks_.advance(dt);
    imu_.begin_frame(t_ns);
  }
  /// The extrinsics in use. Before initialization the lever arm is left out, because without depth the unit of length
  /// is not metric: the body is then the camera, rotated.
  SE3<S> T_body_cam(const SE3<S>& extrinsics) const {
    return initialized_ ? extrinsics : SE3<S>(extrinsics.rotation(), zeros<S, 3>());
  }

  /// Predicts the frame's state. The position sigma grows with outage_s, the time since the last usable image [s].
  Prediction<State, S> predict(const State& latest, const View<Sensors>& view, S outage_s, auto&& align_motion) {
    const auto& increment = imu_.since_frame().increment();
    if (!initialized_) {
      State x = latest;
      x.T_world_body = SE3<S>(view.T_world_previous.rotation() * increment.delta.dR,
                              view.T_world_previous.p() + view.dt * latest.v_world_body);
      return {x, {}};
    }
    Prediction<State, S> out{calibration_.time_offset().at_boundary(latest), {true}};
    if (is_stationary()) set_zero(out.state.v_world_body);
    previous_state_ = out.state;
    predicted_state_ = increment.predict(previous_state_, gravity_);
    if (!imu_.is_unusable()) {
      out.state = predicted_state_;
      if (is_stationary()) set_zero(out.state.v_world_body);
    } else {
      const bool rotation_unknown = imu_.is_missing() || imu_.coverage().gyro_saturated_s > 0;
      const SO3<S> R = rotation_unknown ? SO3<S>() : increment.corrected(latest.bias_gyro, latest.bias_accel).dR;
      const SE3<S> T(view.T_world_previous.rotation() * R, latest.T_world_body.p() + view.dt * latest.v_world_body);
      out.state.T_world_body = rotation_unknown ? with_image_rotation(T, view, align_motion) : T;
    }
    gates_.predict(increment, velocity_, outage_s, options_, out.prior);
    return out;
  }

  /// Innovation gate: whether the pose T by the images is excluded by the IMU prediction (a frozen image, a scene that
  /// moves as a whole).                                                         docs/math/inertial_window.md (1b)
  bool contradicts(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    return !imu_.is_unusable() && !PoseGates<S>::passes_innovation(predicted, T, checks_.innovation_gate(options_));
  }
  /// Consensus gate of RANSAC: whether T is near the IMU prediction. A pose that passes is preferred to one with more
  /// inliers that does not. Always true where the window does not determine the velocity.
  bool passes_gate(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    return gates_.passes_consensus(predicted, T, options_.consensus_gate);
  }
  State update(const State& predicted, const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    State x = predicted;
    checks_.begin_update();
    calibration_.update(T.rotation(), covariance, predicted.bias_gyro, imu_);
    if (initialized_)
      checks_.check_accelerometer(T, covariance, is_stationary(), previous_state_, predicted_state_, view, options_,
                                  imu_, since_keyframe_);
    if (initialized_ && !imu_.is_unusable() && checks_.detect_jump(x, T, covariance, view.dt))
      since_keyframe_.mark_jumped();
    if (!initialized_) x.v_world_body = (T.p() - view.T_world_previous.p()) / view.dt;
    if (!initialized_ || imu_.is_unusable()) x.T_world_body = T;
    return x;
  }
  /// Corrects the velocity of a solved state to that of the images, when the IMU has been unusable since the keyframe.
  bool correct(const State& before, State& solved, S dt) const {
    return since_keyframe_.correct(before, solved, dt, S(options_.suspect_accel_sigma));
  }
  /// Upper bound of the rotation error of the frames up to this one by a gyroscope bias jump [rad], else 0.
  S gyro_jump_rotation() const { return checks_.jump_rotation(); }
  /// Sets the velocity sigma of the latest state by P, the covariance of its pose and velocity in the window; and that
  /// of the last solved state, whose velocity is v [m/s].
  void set_velocity_covariance(const typename VelocityUncertainty<S>::Covariance& P) {
    velocity_.set_latest(P, options_.velocity_inflation);
  }
  void set_speed_covariance(const typename VelocityUncertainty<S>::Covariance& P, const Vec<S, 3>& v) {
    velocity_.set_solved(P, v);
  }
  double speed() const { return velocity_.speed(); }
  double speed_sigma() const { return velocity_.speed_sigma(); }
  void mark_lost() {
    velocity_.set_unknown();
    checks_.interrupt();
  }
  bool can_propagate() const { return initialized_; }
  /// Covariance of a pose after one more frame of IMU-only propagation, outage_s after the last usable frame.
  Mat<S, 6, 6> grown_covariance(const Mat<S, 6, 6>& before, S outage_s) const {
    return velocity_.grown(before, imu_.since_frame().increment(), outage_s);
  }
  /// Resets the motion: a new world frame, velocity zero, biases kept.
  State restart(const State& latest) {
    initialized_ = false;
    checks_.restart(options_.accel_check);
    imu_.inflate_accelerometer_noise(S(0));
    calibration_.restart();
    State x = latest;
    x.T_world_body = {};
    set_zero(x.v_world_body);
    return x;
  }

  const CameraImuFilter& camera_imu() const { return calibration_.filter(); }
  /// The time offset at the end of initialization, as prior of the window (CameraImuCalibration::estimate).
  TimeOffsetEstimate time_offset(double converged_sigma_s) const {
    return calibration_.estimate(!(options_.camera_imu.time_offset_sigma_s > 0), converged_sigma_s);
  }
  /// Whether scale, gravity, velocities and biases are estimated.
  bool is_initialized() const { return initialized_; }
  void set_initialized() {
    initialized_ = true;
    velocity_.reset_speed();
    calibration_.set_initialized();
  }

  Factor factor(int keyframe) const {
    return {keyframe,
            since_keyframe_.intervals(),
            imu_.noise(),
            is_stationary(),
            since_keyframe_.has_jumped(),
            calibration_.time_offset().keyframe(),
            calibration_.time_offset().boundary(),
            checks_.is_accel_suspect()};
  }
  void begin_factor() {
    since_keyframe_.restart();
    calibration_.time_offset().begin_factor();
  }
  /// Decides whether the frame becomes a keyframe. It does not at rest. Otherwise it does by the rule (`needed`); when
  /// the IMU is stationary, so that later images can be compared with this one; and when the IMU is usable again after
  /// a factor with unusable samples or a bias jump, so that the next factor determines the velocity.
  bool confirm_keyframe(TimeNs t_ns, auto&& motion_px, bool needed) {
    const bool was_stationary = is_stationary();
    const double factor_s = since_keyframe_.duration_s();
    const bool long_enough = was_stationary || factor_s >= options_.stationary_check_s;
    const bool is_resting = long_enough && detect_stationarity(t_ns, motion_px());
    // The stationary state is that of the keyframe: samples before the last frame do not constrain later frames.
    if (initialized_ && was_stationary && (!is_resting || factor_s > options_.max_stationary_factor_s)) {
      since_keyframe_.keep_last(imu_.since_frame().intervals());
      calibration_.time_offset().begin_factor_at_previous();
    }
    if (is_resting) return false;
    const bool can_be_stationary = initialized_ && long_enough && stationarity_.was_imu_stationary();
    return needed || can_be_stationary || (since_keyframe_.is_suspect() && !imu_.is_unusable());
  }
  HealthReason diagnose(const auto& factors, const auto& window, bool few_features) {
    if (few_features) checks_.interrupt();
    const bool solved = initialized_ && !is_stationary();  // the window is not optimized at rest
    return checks_.diagnose(solved ? factors.disagreement(window) : 0, imu_, options_);
  }
  bool is_inconsistent() const { return checks_.is_inconsistent(); }
  /// Whether the body has been stationary since the last keyframe, by images and IMU.
  bool detect_stationarity(TimeNs t_ns, double motion_px) {
    return stationarity_.detect(imu_, t_ns, motion_px, options_);
  }
  bool is_stationary() const { return stationarity_.is_stationary(); }
  /// Whether the IMU is stationary. Uniform motion in a straight line has the same samples.
  bool can_be_stationary(TimeNs t_ns) { return stationarity_.is_imu_stationary(imu_, t_ns, options_); }
  State stationary_state() const { return stationarity_.state(options_.gravity); }

  const Vec<S, 3>& angular_rate() const { return twist_.rate(); }
  static Vec<S, 3> velocity(const State& x) { return x.T_world_body.rotation().inverse() * x.v_world_body; }
  /// Velocity [rad/s, m/s] before initialization, in this frame and in the previous one, this body being at T.
  Vec<S, 6> motion_at(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return twist_.twist(predicted, T, view, T.rotation(), twist_.rate());
  }
  Vec<S, 6> motion_before(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return twist_.twist(predicted, T, view, view.T_world_previous.rotation(), twist_.rate_before());
  }

 private:
  Options options_;
  Vec<S, 3> gravity_;
  ImuIntegrator<S> imu_;
  SamplesSinceKeyframe<S> since_keyframe_;
  CameraImuCalibration<S> calibration_;
  FrameTwist<S> twist_;
  VelocityUncertainty<S> velocity_;
  PoseGates<S> gates_;
  ImuChecks<S> checks_;
  State previous_state_, predicted_state_;  ///< where the increment begins, and that propagated by the IMU
  StationarityDetector<S> stationarity_;
  bool initialized_ = false;
};

}  // namespace plumbline
