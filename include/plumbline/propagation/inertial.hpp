#pragma once
/// Propagation of a rig with an IMU: IMU samples predict the next frame and give the IMU factor to the last keyframe.
///                                                                                docs/math/inertial_window.md
/// Before initialization the gyroscope predicts the rotation and the velocity of the images the translation. While the
/// IMU is unusable (samples missing or saturated) images give both.

#include <algorithm>
#include <cmath>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/imu/stationarity.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/propagation/accelerometer_check.hpp"
#include "plumbline/propagation/camera_time_offset.hpp"
#include "plumbline/propagation/gyroscope_check.hpp"
#include "plumbline/propagation/imu_factors.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/propagation/inertial_options.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
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
        T_body_cam_calibrated_(rig.T_body_cam()),
        gravity_(gravity_in_world<S>(S(options.gravity))),
        imu_(rig.imu, options.inflated(rig.imu.noise)),
        since_keyframe_(imu_.since(State{})),
        camera_imu_(options.camera_imu),
        time_offset_(rig.imu.camera_time_offset_s),
        velocity_sigma_(options.velocity_sigma),
        gyro_check_(options.gyro_check),
        accel_check_(options.accel_check) {}

  const Options& options() const { return options_; }
  ImuIntegrator<S>& imu() { return imu_; }
  const ImuIntegrator<S>& imu() const { return imu_; }

  /// Applies the estimated extrinsics and time offset from the next frame on. A reset discards what the window has
  /// estimated of them. Returns the time offset, t_imu = t_image + offset [s].
  double calibrate(auto& rig, const auto& window) {
    const SE3<S>& T_body_cam = window.T_body_cam(T_body_cam_calibrated_);
    const SO3<S> rotation_step = T_body_cam.rotation() * rig.T_body_cam().rotation().inverse();
    camera_imu_.rotate_extrinsics(cast_to<double>(rotation_step.log()));
    rig.set_T_body_cam(T_body_cam);
    time_offset_.calibrate(camera_imu_, window, initialized_, options_.camera_imu.max_step_s);
    rig.set_time_offset(time_offset_.offset_s());
    imu_.set_camera_time_offset(time_offset_.offset_s());
    return time_offset_.offset_s();
  }
  /// Takes the time offset of the window at once, with or without active factors.
  void adopt_time_offset(const auto& window) {
    time_offset_.calibrate(camera_imu_, window, /*in_window=*/true, options_.camera_imu.max_correction_s);
  }
  void begin_frame(TimeNs t_ns, const State* latest, S dt) {
    if (latest) {
      imu_.integrate(t_ns, *latest);
      if (imu_.is_missing()) camera_imu_.reset_world();
      camera_imu_.propagate(imu_.since_frame().increment());
      since_keyframe_.append(imu_.since_frame());
      unusable_since_keyframe_ = unusable_since_keyframe_ || imu_.is_unusable();
      angular_rate_before_ = angular_rate_;
      angular_rate_ = latest_rate(latest->bias_gyro, dt);
      is_stationary_ = is_stationary_ && imu_is_stationary(t_ns);
    }
    time_offset_.set_gyro(imu_.latest_gyro(options_.rate_window_s));
    gyro_check_.advance(dt);
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
    Prediction<State, S> out{time_offset_.at_boundary(latest), {true}};
    has_position_sigma_ = velocity_sigma_ < options_.velocity_sigma;
    if (is_stationary_) set_zero(out.state.v_world_body);
    previous_state_ = out.state;
    predicted_state_ = increment.predict(previous_state_, gravity_);
    if (!imu_.is_unusable()) {
      out.state = predicted_state_;
      if (is_stationary_) set_zero(out.state.v_world_body);
    } else {
      const bool rotation_unknown = imu_.is_missing() || imu_.coverage().gyro_saturated_s > 0;
      const SO3<S> R = rotation_unknown ? SO3<S>() : increment.corrected(latest.bias_gyro, latest.bias_accel).dR;
      const SE3<S> T(view.T_world_previous.rotation() * R, latest.T_world_body.p() + view.dt * latest.v_world_body);
      out.state.T_world_body = rotation_unknown ? with_image_rotation(T, view, align_motion) : T;
    }
    for (int k = 0; k < 3; ++k) {
      const auto sigma = [&](int i) { return std::sqrt(double(increment.covariance(i, i))); };
      out.prior.sigma[k] = S(elementary::hypot(options_.rotation_sigma, sigma(k)));
      out.prior.sigma[3 + k] = S(elementary::hypot(options_.velocity_sigma * double(outage_s), sigma(3 + k)));
      position_sigma_[k] = S(elementary::hypot(velocity_sigma_ * double(outage_s), sigma(3 + k)));
    }
    return out;
  }

  /// Innovation gate: whether the pose T by the images is excluded by the IMU prediction (a frozen image, a scene that
  /// moves as a whole). The gate is wider while the gyroscope is suspect.         docs/math/inertial_window.md (1b)
  bool contradicts(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    const double usual =
        gyro_check_.is_suspect() ? suspect_gate_ratio * options_.innovation_gate : options_.innovation_gate;
    const double gate = gyro_check_.has_recent_jump() ? options_.innovation_gate_after_jump : usual;
    return !imu_.is_unusable() && !predicted.prior.passes_gate(minus(T, predicted.state.T_world_body), S(gate));
  }
  /// Consensus gate of RANSAC: whether T is near the IMU prediction. A pose that passes is preferred to one with more
  /// inliers that does not. Always true where the window does not determine the velocity.
  bool passes_gate(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    if (!has_position_sigma_) return true;
    PosePrior<S> prior = predicted.prior;
    set_segment(prior.sigma, 3, position_sigma_);
    return prior.passes_gate(minus(T, predicted.state.T_world_body), S(options_.consensus_gate));
  }

  State update(const State& predicted, const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    State x = predicted;
    gyro_jump_rotation_ = S(0);
    update_camera_imu_filter(T.rotation(), covariance, predicted.bias_gyro);
    if (initialized_) check_accelerometer(T, covariance, view);
    if (initialized_ && !imu_.is_unusable()) detect_gyro_jump(x, T, covariance, view.dt);
    if (!initialized_) x.v_world_body = (T.p() - view.T_world_previous.p()) / view.dt;
    if (!initialized_ || imu_.is_unusable()) x.T_world_body = T;
    return x;
  }
  /// Corrects the velocity of a solved state to that of the images, when the IMU has been unusable since the keyframe.
  /// The change is limited to what a suspect accelerometer allows.               docs/math/inertial_window.md (1k)
  bool correct(const State& before, State& solved, S dt) const {
    if (!unusable_since_keyframe_) return false;
    const Vec<S, 3> v_images = (solved.T_world_body.p() - before.T_world_body.p()) / dt,
                    change = v_images - before.v_world_body;
    const S change_norm = norm(change), max_change = S(options_.suspect_accel_sigma) * dt;
    solved.v_world_body =
        change_norm > max_change ? Vec<S, 3>(before.v_world_body + (max_change / change_norm) * change) : v_images;
    return true;
  }
  /// Upper bound of the rotation error of the frames up to this one by a gyroscope bias jump [rad], else 0.
  S gyro_jump_rotation() const { return gyro_jump_rotation_; }
  /// Sets the velocity sigma of the latest state from the covariance P of its pose and velocity in the window.
  void set_velocity_covariance(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P) {
    velocity_sigma_ = std::min(options_.velocity_sigma, options_.velocity_inflation * largest_velocity_sigma(P));
  }
  /// Sets speed and velocity sigma of the last state solved with the window: covariance P, velocity v [m/s].
  void set_speed_covariance(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P, const Vec<S, 3>& v) {
    solved_velocity_sigma_ = largest_velocity_sigma(P);
    speed_ = std::sqrt(double(squared_norm(v)));
    speed_sigma_ = std::sqrt(double(dot(v, block<3, 3>(P, at_velocity, at_velocity) * v))) / speed_;
  }
  /// Speed of that state and its sigma [m/s]. Without depth its relative sigma bounds that of the scale.
  double speed() const { return speed_; }
  double speed_sigma() const { return speed_sigma_; }
  void mark_lost() {
    velocity_sigma_ = options_.velocity_sigma;
    accel_check_.interrupt();
  }
  bool can_propagate() const { return initialized_; }
  /// Covariance of a pose after one more frame of IMU-only propagation, outage_s after the last usable frame.
  ///                                                                             docs/math/inertial_window.md (1f)
  Mat<S, 6, 6> grown_covariance(const Mat<S, 6, 6>& before, S outage_s) const {
    const auto& increment = imu_.since_frame().increment();
    const S t = increment.duration, v = S(solved_velocity_sigma_), walk = S(options_.velocity_sigma);
    Mat<S, 6, 6> out = before + block<6, 6>(increment.covariance, 0, 0);
    for (int k = 3; k < 6; ++k) out(k, k) += walk * walk * t + v * v * (2 * outage_s - t) * t;
    return out;
  }
  /// Resets the motion: a new world frame, velocity zero, biases kept.
  State restart(const State& latest) {
    initialized_ = false;
    accel_check_ = AccelerometerCheck<S>(options_.accel_check);
    imu_.inflate_accelerometer_noise(S(0));
    time_offset_.reset_window_correction(camera_imu_);
    camera_imu_.reset_world();
    State x = latest;
    x.T_world_body = {};
    set_zero(x.v_world_body);
    return x;
  }

  const CameraImuFilter& camera_imu() const { return camera_imu_; }
  /// The time offset at the end of initialization, as prior of the window. `converged_sigma_s`: sigma of the filter
  /// below which the offset in use is accepted even if the filter finds an error of more than one sigma [s].
  TimeOffsetEstimate time_offset(double converged_sigma_s) const {
    return {time_offset_.offset_s(), camera_imu_.is_time_offset_wrong() ? camera_imu_.time_offset_sigma() : 0,
            !(options_.camera_imu.time_offset_sigma_s > 0), !camera_imu_.accepts_time_offset(converged_sigma_s)};
  }

  /// Whether scale, gravity, velocities and biases are estimated.
  bool is_initialized() const { return initialized_; }
  void set_initialized() {
    initialized_ = true;
    speed_ = 0;
    camera_imu_.reset_extrinsics();
    camera_imu_.reset_world();
  }

  Factor factor(int keyframe) const {
    return {keyframe,
            since_keyframe_,
            is_stationary_,
            jumped_since_keyframe_,
            time_offset_.keyframe(),
            time_offset_.boundary(),
            accel_check_.is_suspect()};
  }
  void begin_factor(const State& x) {
    since_keyframe_ = imu_.since(x);
    time_offset_.begin_factor();
    unusable_since_keyframe_ = jumped_since_keyframe_ = false;
  }
  /// Decides whether the frame becomes a keyframe. It does not at rest. Otherwise it does by the rule (`needed`); when
  /// the IMU is stationary, so that later images can be compared with this one; and when the IMU is usable again after
  /// a factor with unusable samples or a bias jump, so that the next factor determines the velocity.
  bool confirm_keyframe(TimeNs t_ns, auto&& motion_px, bool needed) {
    const bool was_stationary = is_stationary_;
    const double factor_s = double(since_keyframe_.increment().duration);
    const bool long_enough = was_stationary || factor_s >= options_.stationary_check_s;
    const bool is_resting = long_enough && detect_stationarity(t_ns, motion_px());
    // The stationary state is that of the keyframe: samples before the last frame do not constrain later frames.

    if (initialized_ && was_stationary && (!is_resting || factor_s > options_.max_stationary_factor_s)) {
      since_keyframe_ = imu_.since_frame();
      time_offset_.begin_factor_at_previous();
    }
    if (is_resting) return false;
    const bool can_be_stationary = initialized_ && long_enough && stationarity_.is_stationary();
    return needed || can_be_stationary || ((unusable_since_keyframe_ || jumped_since_keyframe_) && !imu_.is_unusable());
  }
  HealthReason diagnose(const auto& factors, const auto& window, bool few_features) {
    if (few_features) accel_check_.interrupt();
    const bool solved = initialized_ && !is_stationary_;  // the window is not optimized at rest
    factors_disagree_ = solved && factors.disagreement(window) > options_.max_disagreement;
    if (imu_.is_missing()) return HealthReason::no_imu_data;
    // Clipping at a full scale near gravity has the effect of a bias on later samples.
    const bool saturates_at_gravity = imu_.buffer().accel_full_scale() < options_.min_full_scale * options_.gravity;
    if (imu_.coverage().saturated_s > 0 || saturates_at_gravity) return HealthReason::imu_saturated;
    return is_inconsistent() ? HealthReason::imu_disagrees : HealthReason::none;
  }
  /// Whether images and IMU are inconsistent, by the last diagnosis, also where its reason is another one.
  bool is_inconsistent() const {
    return factors_disagree_ || gyro_check_.has_recent_jump() || accel_check_.is_suspect();
  }

  /// Whether the body has been stationary since the last keyframe, by images and IMU. The limits have hysteresis.
  bool detect_stationarity(TimeNs t_ns, double motion_px) {
    const double scale = is_stationary_ ? options_.stationary_hysteresis : 1;
    return is_stationary_ = imu_is_stationary(t_ns) && motion_px < scale * options_.stationary_motion_px;
  }
  bool is_stationary() const { return is_stationary_; }
  /// Whether the IMU is stationary. Uniform motion in a straight line has the same samples.
  bool can_be_stationary(TimeNs t_ns) { return imu_is_stationary(t_ns); }
  /// The stationary state: tilt and biases by the IMU, velocity zero, at the origin of an upright world.
  State stationary_state() const { return plumbline::stationary_state<S>(stationarity_, options_.gravity); }

  const Vec<S, 3>& angular_rate() const { return angular_rate_; }
  static Vec<S, 3> velocity(const State& x) { return x.T_world_body.rotation().inverse() * x.v_world_body; }
  /// Velocity [rad/s, m/s] before initialization, in this frame and in the previous one, this body being at T: the rate
  /// of the gyroscope, the mean velocity of the last three images.           docs/math/rolling_shutter.md (1f)
  Vec<S, 6> motion_at(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return twist(predicted, T, view, T.rotation(), angular_rate_);
  }
  Vec<S, 6> motion_before(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return twist(predicted, T, view, view.T_world_previous.rotation(), angular_rate_before_);
  }

 private:
  /// Of innovation_gate while the gyroscope is suspect; tuned: docs/decisions/014.
  static constexpr double suspect_gate_ratio = 2;

  Vec<S, 6> twist(const State& predicted, const SE3<S>& T, const View<Sensors>& view, const SO3<S>& R_world_body,
                  const Vec<S, 3>& angular_rate) const {
    const Vec<S, 3> v = (T.p() - view.T_world_previous.p()) / view.dt;
    Vec<S, 6> out;
    set_segment(out, 0, angular_rate);
    set_segment(out, 3, Vec<S, 3>(R_world_body.inverse() * Vec<S, 3>((predicted.v_world_body + v) / S(2))));
    return out;
  }

  /// Angular rate at the end of the samples, extrapolated linearly [rad/s].   docs/math/rolling_shutter.md (1d)
  Vec<S, 3> latest_rate(const Vec<S, 3>& bias_gyro, S dt) const {
    if (imu_.since_frame().empty()) return imu_.since_frame().increment().delta.dR.log() / dt;
    return 2 * imu_.latest_gyro(options_.rate_window_s / 2) - imu_.latest_gyro(options_.rate_window_s) - bias_gyro;
  }

  /// Updates the filter of time offset and extrinsics with the orientation by the images.
  void update_camera_imu_filter(const SO3<S>& R, const Mat<S, 6, 6>& covariance, const Vec<S, 3>& bias_gyro) {
    if (imu_.since_frame().empty()) return;
    const Vec<S, 3> rate = imu_.since_frame().intervals().back().mean_gyro() - bias_gyro;
    camera_imu_.update(R.template cast<double>(), cast_to<double>(block<3, 3>(covariance, 0, 0)),
                       cast_to<double>(rate));
  }

  /// Updates the accelerometer check. After a detection the accelerometer noise is inflated, so that images and
  /// gyroscope determine the motion. There is no check while these two disagree.
  void check_accelerometer(const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    const ImuCoverage& coverage = imu_.coverage();
    const bool usable =
        coverage.missing() == 0 && coverage.saturated_s == 0 && !is_stationary_ && !gyro_check_.has_recent_jump();
    if (!usable) accel_check_.interrupt();
    if (!usable || gyro_check_.is_suspect()) return;
    const bool was_suspect = accel_check_.is_suspect();
    const S sigma = std::sqrt((covariance(3, 3) + covariance(4, 4) + covariance(5, 5)) / S(3));
    accel_check_.update(T.p(), sigma, view.T_world_previous.p(), previous_state_, predicted_state_, view.dt,
                        factors_disagree_);
    const S noise = accel_check_.is_suspect() ? S(options_.suspect_accel_sigma) : S(0);
    imu_.inflate_accelerometer_noise(noise);
    if (noise > S(0) && !was_suspect) {
      since_keyframe_.inflate_accelerometer_noise(noise);
      unusable_since_keyframe_ = true;
    }
  }

  static constexpr int at_velocity = MovingLayout::offset<state::Velocity>;
  static double largest_velocity_sigma(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P) {
    constexpr int v = at_velocity;
    return std::sqrt(double(std::max({P(v, v), P(v + 1, v + 1), P(v + 2, v + 2)})));
  }

  /// Corrects gyroscope bias and rotation when a jump is detected, with the error of the prediction
  ///   d = log(R_predicted^T R_images) = -(b - b_predicted) dt                  docs/math/inertial_window.md (1c)
  void detect_gyro_jump(State& x, const SE3<S>& T, const Mat<S, 6, 6>& covariance, S dt) {
    const Vec<S, 3> d = (x.T_world_body.rotation().inverse() * T.rotation()).log();
    if (!gyro_check_.update(d, (covariance(0, 0) + covariance(1, 1) + covariance(2, 2)) / S(3), dt)) return;
    gyro_jump_rotation_ = gyro_check_.gyro_jump_rotation();
    x.bias_gyro -= gyro_check_.rate_error();
    x.T_world_body = T;
    gyro_check_.reset_after_jump();
    jumped_since_keyframe_ = true;
  }

  /// Whether the IMU is stationary; the limits have hysteresis.
  bool imu_is_stationary(TimeNs t_ns) {
    StationarityOptions options = options_.stationarity;
    const double scale = is_stationary_ ? options_.stationary_hysteresis : 1;
    options.gyro_spread *= scale;
    options.accel_spread *= scale;
    stationarity_ = stationarity(imu_.buffer(), imu_.time_of(t_ns), options, options_.gravity);
    return stationarity_.is_stationary();
  }

  Options options_;
  SE3<S> T_body_cam_calibrated_;
  Vec<S, 3> gravity_;
  ImuIntegrator<S> imu_;
  Preintegration<S> since_keyframe_;
  CameraImuFilter camera_imu_;
  CameraTimeOffset<S> time_offset_;
  Vec<S, 3> angular_rate_ = zeros<S, 3>();         ///< in this frame [rad/s]
  Vec<S, 3> angular_rate_before_ = zeros<S, 3>();  ///< in the previous frame [rad/s]
  double velocity_sigma_;                          ///< of the latest state, inflated [m/s]
  double solved_velocity_sigma_ = 0;               ///< largest axis, of the last state solved with the window [m/s]
  double speed_ = 0, speed_sigma_ = 0;             ///< of that state [m/s]
  Vec<S, 3> position_sigma_ = zeros<S, 3>();       ///< of the predicted frame [m]
  GyroscopeCheck<S> gyro_check_;
  S gyro_jump_rotation_ = S(0);  ///< of this frame [rad]
  AccelerometerCheck<S> accel_check_;
  State previous_state_;   ///< of the previous frame, where the increment begins
  State predicted_state_;  ///< previous_state_ propagated by the IMU
  StationarityReport stationarity_;
  bool initialized_ = false, unusable_since_keyframe_ = false, jumped_since_keyframe_ = false, is_stationary_ = false;
  bool factors_disagree_ = false;
  bool has_position_sigma_ = false;  ///< position_sigma_ is determined
};

}  // namespace plumbline
