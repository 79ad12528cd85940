#pragma once
/// Motion of a rig with an IMU: the readings since the last frame predict the next one, and tie it to the keyframe.
///                                                                                docs/math/inertial_window.md
/// Until scale, gravity and velocity are known the gyroscope gives the rotation, and images a velocity of their own.
/// Where the readings say nothing (missing, saturated) both come from the images.

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/imu/standstill.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/motion/accelerometer_check.hpp"
#include "plumbline/motion/camera_clock.hpp"
#include "plumbline/motion/gyroscope_check.hpp"
#include "plumbline/motion/imu_intake.hpp"
#include "plumbline/motion/inertial_links.hpp"
#include "plumbline/motion/inertial_options.hpp"
#include "plumbline/motion/motion_model.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/clock_belief.hpp"
#include "plumbline/state/frame_state.hpp"

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
  using Links = InertialLinks<S, Slots>;
  using Link = InertialLink<S>;
  static constexpr bool is_chain = true;

  Inertial(const Sensors& rig, const Options& options)
      : options_(options),
        T_body_cam_calibrated_(rig.T_body_cam()),
        gravity_(gravity_in_world<S>(S(options.gravity))),
        imu_(rig.imu, options.inflated(rig.imu.noise)),
        since_keyframe_(imu_.since(State{})),
        camera_imu_(options.camera_imu),
        clock_(rig.imu.camera_time_offset_s),
        velocity_sigma_(options.velocity_sigma),
        gyro_check_(options.gyro_check),
        accel_check_(options.accel_check) {}

  const Options& options() const { return options_; }
  ImuIntake<S>& imu() { return imu_; }
  const ImuIntake<S>& imu() const { return imu_; }

  /// What was found out about camera and IMU is in force from the next frame on; what the window found until all begins
  /// anew: where an estimate went wrong, so may they have. Returns the camera's time offset [s].
  double calibrate(auto& rig, const auto& window) {
    const SE3<S>& T_body_cam = window.T_body_cam(T_body_cam_calibrated_);
    const SO3<S> turned = T_body_cam.rotation() * rig.T_body_cam().rotation().inverse();
    camera_imu_.turn_mount(cast_to<double>(turned.log()));
    rig.set_T_body_cam(T_body_cam);
    clock_.calibrate(camera_imu_, window, is_metric_, options_.camera_imu.max_step_s);
    rig.set_time_offset(clock_.offset_s());
    imu_.set_camera_time_offset(clock_.offset_s());
    return clock_.offset_s();
  }
  /// The camera's clock goes as the window has found out, whether frames are tied or not.
  void believe_clock_of(const auto& window) {
    clock_.calibrate(camera_imu_, window, /*in_window=*/true, options_.camera_imu.max_correction_s);
  }
  void begin_frame(TimeNs t_ns, const State* latest, S dt) {
    if (latest) {
      imu_.integrate(t_ns, *latest);
      if (imu_.missing()) camera_imu_.forget_world();
      camera_imu_.propagate(imu_.since_frame().increment());
      since_keyframe_.append(imu_.since_frame());
      blind_since_keyframe_ = blind_since_keyframe_ || imu_.blind();
      angular_rate_before_ = angular_rate_;
      angular_rate_ = latest_rate(latest->bias_gyro, dt);
      at_rest_ = at_rest_ && seems_at_rest(t_ns);
    }
    clock_.set_gyro(imu_.latest_gyro(options_.rate_s));
    gyro_check_.pass(dt);
    imu_.begin_frame(t_ns);
  }
  /// Vision alone has no use for the lever arm: its body is the camera, turned. (Without depth it has another unit.)
  SE3<S> T_body_cam(const SE3<S>& extrinsics) const {
    return is_metric_ ? extrinsics : SE3<S>(extrinsics.rotation(), zeros<S, 3>());
  }

  /// While images are of no use the velocity gets worse.
  Prediction<State, S> predict(const State& latest, const View<Sensors>& view, S blind_s, auto&& align_motion) {
    const auto& increment = imu_.since_frame().increment();
    if (!is_metric_) {
      State x = latest;
      x.T_world_body = SE3<S>(view.T_world_previous.rotation() * increment.delta.dR,
                              view.T_world_previous.p() + view.dt * latest.v_world_body);
      return {x, {}};
    }
    Prediction<State, S> out{clock_.at_cut(latest), {true}};
    knows_place_ = velocity_sigma_ < options_.velocity_sigma;
    if (at_rest_) set_zero(out.state.v_world_body);
    before_ = out.state;
    foretold_ = increment.predict(before_, gravity_);
    if (!imu_.blind()) {
      out.state = foretold_;
      if (at_rest_) set_zero(out.state.v_world_body);
    } else {
      const bool turn_unknown = imu_.missing() || imu_.coverage().gyro_saturated_s > 0;
      const SO3<S> R = turn_unknown ? SO3<S>() : increment.corrected(latest.bias_gyro, latest.bias_accel).dR;
      const SE3<S> T(view.T_world_previous.rotation() * R, latest.T_world_body.p() + view.dt * latest.v_world_body);
      out.state.T_world_body = turn_unknown ? turned_as_seen(T, view, align_motion) : T;
    }
    for (int k = 0; k < 3; ++k) {
      const auto sigma = [&](int i) { return std::sqrt(double(increment.covariance(i, i))); };
      out.prior.sigma[k] = S(std::hypot(options_.rotation_sigma, sigma(k)));
      out.prior.sigma[3 + k] = S(std::hypot(options_.velocity_sigma * double(blind_s), sigma(3 + k)));
      place_sigma_[k] = S(std::hypot(velocity_sigma_ * double(blind_s), sigma(3 + k)));
    }
    return out;
  }

  /// Whether images say of the frame what its readings exclude: a frozen picture, a scene that moves as a whole.
  /// A gyroscope that may be at fault does not rule: less is excluded until it is decided.
  bool contradicts(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    const double usual = gyro_check_.is_suspect() ? 2 * options_.max_innovation : options_.max_innovation;
    const double gate = gyro_check_.in_doubt() ? options_.doubted_innovation : usual;
    return !imu_.blind() && !predicted.prior.admits(minus(T, predicted.state.T_world_body), S(gate));
  }
  /// Whether a pose is near enough to what the readings foretell to be preferred to what more landmarks agree on: where
  /// the window tells how well it knows the velocity.
  bool admits(const Prediction<State, S>& predicted, const SE3<S>& T) const {
    if (!knows_place_) return true;
    PosePrior<S> prior = predicted.prior;
    set_segment(prior.sigma, 3, place_sigma_);
    return prior.admits(minus(T, predicted.state.T_world_body), S(options_.max_vote));
  }

  State update(const State& predicted, const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    State x = predicted;
    turned_wrongly_ = S(0);
    compare_orientation(T.rotation(), covariance, predicted.bias_gyro);
    if (is_metric_) check_accelerometer(T, covariance, view);
    if (is_metric_ && !imu_.blind()) look_for_jump(x, T, covariance, view.dt);
    if (!is_metric_) x.v_world_body = (T.p() - view.T_world_previous.p()) / view.dt;
    if (!is_metric_ || imu_.blind()) x.T_world_body = T;
    return x;
  }
  /// Where the readings were of no use the images tell the velocity. A place that jumps tells none: it changes by no
  /// more than a doubted accelerometer could be wrong by.
  bool revise(const State& before, State& solved, S dt) const {
    if (!blind_since_keyframe_) return false;
    const Vec<S, 3> seen = (solved.T_world_body.p() - before.T_world_body.p()) / dt,
                    change = seen - before.v_world_body;
    const S size = norm(change), most = S(options_.accel_doubt) * dt;
    solved.v_world_body = size > most ? Vec<S, 3>(before.v_world_body + (most / size) * change) : seen;
    return true;
  }
  /// By how much a gyroscope may have turned the frames up to this one that was found wrong in it [rad], else 0.
  S turned_wrongly() const { return turned_wrongly_; }
  /// How well the window knows the latest state, its velocity after its pose.
  void know_velocity(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P) {
    velocity_sigma_ = std::min(options_.velocity_sigma, options_.velocity_doubt * largest_velocity_sigma(P));
  }
  /// The same of a state that was solved for with the window, if not the latest one, and moves at v.
  void know_speed(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P, const Vec<S, 3>& v) {
    solved_velocity_sigma_ = largest_velocity_sigma(P);
    speed_ = std::sqrt(double(squared_norm(v)));
    speed_sigma_ = std::sqrt(double(dot(v, block<3, 3>(P, at_velocity, at_velocity) * v))) / speed_;
  }
  /// Of that state, and how well the window knows it [m/s]: without depth it does not know the scale any better.
  double speed() const { return speed_; }
  double speed_sigma() const { return speed_sigma_; }
  void lose() {
    velocity_sigma_ = options_.velocity_sigma;
    accel_check_.interrupt();
  }
  bool carries_on() const { return is_metric_; }
  /// Of a pose after the readings of one frame without images, blind_s after the last one of use.
  Mat<S, 6, 6> covariance_grown(const Mat<S, 6, 6>& before, S blind_s) const {
    const auto& increment = imu_.since_frame().increment();
    const S t = increment.duration, v = S(solved_velocity_sigma_), walk = S(options_.velocity_sigma);
    Mat<S, 6, 6> out = before + block<6, 6>(increment.covariance, 0, 0);
    for (int k = 3; k < 6; ++k) out(k, k) += walk * walk * t + v * v * (2 * blind_s - t) * t;
    return out;
  }
  /// In a world of its own: what is kept are the biases.
  State restart(const State& latest) {
    is_metric_ = false;
    accel_check_ = AccelerometerCheck<S>(options_.accel_check);
    imu_.doubt_accelerometer(S(0));
    clock_.forget_window(camera_imu_);
    camera_imu_.forget_world();
    State x = latest;
    x.T_world_body = {};
    set_zero(x.v_world_body);
    return x;
  }

  const CameraImuFilter& camera_imu() const { return camera_imu_; }
  /// The camera's, as it is known before frames and readings are solved for together; `sure_s`: sigma of one that is in
  /// no doubt whatever speaks against it.
  ClockBelief clock(double sure_s) const {
    return {clock_.offset_s(), camera_imu_.clock_is_wrong() ? camera_imu_.time_offset_sigma() : 0,
            !(options_.camera_imu.time_offset_sigma_s > 0), !camera_imu_.believes_clock(sure_s)};
  }

  /// Whether scale, gravity, velocities and biases are known.
  bool is_metric() const { return is_metric_; }
  void become_metric() {
    is_metric_ = true;
    speed_ = 0;
    camera_imu_.forget_mount();
    camera_imu_.forget_world();
  }
  bool ties_frames() const { return is_metric_; }

  Link link(int keyframe) const {
    return {keyframe,     since_keyframe_,        at_rest_, jumped_since_keyframe_, clock_.keyframe(),
            clock_.cut(), accel_check_.in_doubt()};
  }
  void begin_link(const State& x) {
    since_keyframe_ = imu_.since(x);
    clock_.begin_link();
    blind_since_keyframe_ = jumped_since_keyframe_ = false;
  }
  /// A link that was blind somewhere ends as soon as the readings are back: the next one tells the velocity. Readings
  /// as of a standstill make a keyframe that the landmarks can be seen to rest against. At rest there are none.
  bool confirm_keyframe(TimeNs t_ns, auto&& motion_px, bool needed) {
    const bool rested = at_rest_;
    const double link_s = double(since_keyframe_.increment().duration);
    const bool long_enough = rested || link_s >= options_.rest_check_s;
    const bool resting = long_enough && look_for_rest(t_ns, motion_px());
    // The state at rest is that of the keyframe: readings before the last frame tell nothing more of what comes.
    if (is_metric_ && rested && (!resting || link_s > options_.max_rest_link_s)) {
      since_keyframe_ = imu_.since_frame();
      clock_.begin_link_before();
    }
    if (resting) return false;
    const bool may_rest = is_metric_ && long_enough && rest_.at_rest();
    return needed || may_rest || ((blind_since_keyframe_ || jumped_since_keyframe_) && !imu_.blind());
  }
  HealthReason doubt(const auto& links, const auto& window, bool few_features) {
    if (few_features) accel_check_.interrupt();
    const bool solved = is_metric_ && !at_rest_;  // at rest frames are not solved for
    links_disagree_ = solved && links.disagreement(window) > options_.max_disagreement;
    if (imu_.missing()) return HealthReason::no_imu_data;
    // What gravity alone drives to the rail and is cut off there looks like a bias to the readings beside it.
    const bool rail_at_gravity = imu_.buffer().accel_full_scale() < options_.min_full_scale * options_.gravity;
    if (imu_.coverage().saturated_s > 0 || rail_at_gravity) return HealthReason::imu_saturated;
    if (gyro_check_.in_doubt() || accel_check_.in_doubt()) return HealthReason::imu_disagrees;
    return links_disagree_ ? HealthReason::imu_disagrees : HealthReason::none;
  }

  /// Whether nothing moved since the last keyframe, by image and IMU. Rest is left less easily than it is entered.
  bool look_for_rest(TimeNs t_ns, double motion_px) {
    const double slack = at_rest_ ? options_.rest_hysteresis : 1;
    return at_rest_ = seems_at_rest(t_ns) && motion_px < slack * options_.rest_motion_px;
  }
  bool at_rest() const { return at_rest_; }
  /// As far as the readings show; even motion in a straight line looks the same.
  bool may_rest(TimeNs t_ns) { return seems_at_rest(t_ns); }
  /// All that is known of a body at rest, the world being upright at its place.
  State state_at_rest() const { return plumbline::state_at_rest<S>(rest_, options_.gravity); }

  const Vec<S, 3>& angular_rate() const { return angular_rate_; }
  static Vec<S, 3> velocity(const State& x) { return x.T_world_body.rotation().inverse() * x.v_world_body; }
  /// Before the start: in this frame and in the one before, the body being at T now; turned as readings say, moved as
  /// the last three images do [rad/s, m/s].                                 docs/math/rolling_shutter.md (1f)
  Vec<S, 6> motion_at(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return moved(predicted, T, view, T.rotation(), angular_rate_);
  }
  Vec<S, 6> motion_before(const State& predicted, const SE3<S>& T, const View<Sensors>& view) const {
    return moved(predicted, T, view, view.T_world_previous.rotation(), angular_rate_before_);
  }

 private:
  Vec<S, 6> moved(const State& predicted, const SE3<S>& T, const View<Sensors>& view, const SO3<S>& R_world_body,
                  const Vec<S, 3>& angular_rate) const {
    const Vec<S, 3> v = (T.p() - view.T_world_previous.p()) / view.dt;
    Vec<S, 6> out;
    set_segment(out, 0, angular_rate);
    set_segment(out, 3, Vec<S, 3>(R_world_body.inverse() * Vec<S, 3>((predicted.v_world_body + v) / S(2))));
    return out;
  }

  /// How the body turns now: where a line through the last readings ends, as a hand turns otherwise half of them ago
  /// [rad/s].                                                              docs/math/rolling_shutter.md (1d)
  Vec<S, 3> latest_rate(const Vec<S, 3>& bias_gyro, S dt) const {
    if (imu_.since_frame().empty()) return imu_.since_frame().increment().delta.dR.log() / dt;
    return 2 * imu_.latest_gyro(options_.rate_s / 2) - imu_.latest_gyro(options_.rate_s) - bias_gyro;
  }

  /// How images and readings turn tells how camera and IMU stand to each other.
  void compare_orientation(const SO3<S>& R, const Mat<S, 6, 6>& covariance, const Vec<S, 3>& bias_gyro) {
    if (imu_.since_frame().empty()) return;
    const Vec<S, 3> rate = imu_.since_frame().intervals().back().mean_gyro() - bias_gyro;
    camera_imu_.update(R.template cast<double>(), cast_to<double>(block<3, 3>(covariance, 0, 0)),
                       cast_to<double>(rate));
  }

  /// An accelerometer that does not tell of the motion seen has no say: the body moves as images and gyroscope have it.
  /// Where these two do not agree the images are in doubt themselves.
  void check_accelerometer(const SE3<S>& T, const Mat<S, 6, 6>& covariance, const View<Sensors>& view) {
    const ImuCoverage& read = imu_.coverage();
    const bool watched = read.missing() == 0 && read.saturated_s == 0 && !at_rest_ && !gyro_check_.in_doubt();
    if (!watched) accel_check_.interrupt();
    if (!watched || gyro_check_.is_suspect()) return;
    const bool was_in_doubt = accel_check_.in_doubt();
    const S sigma = std::sqrt((covariance(3, 3) + covariance(4, 4) + covariance(5, 5)) / S(3));
    accel_check_.update(T.p(), sigma, view.T_world_previous.p(), before_, foretold_, view.dt, links_disagree_);
    const S doubt = accel_check_.in_doubt() ? S(options_.accel_doubt) : S(0);
    imu_.doubt_accelerometer(doubt);
    if (doubt > S(0) && !was_in_doubt) {
      since_keyframe_.doubt_accelerometer(doubt);
      blind_since_keyframe_ = true;
    }
  }

  static constexpr int at_velocity = MovingLayout::offset<state::Velocity>;
  static double largest_velocity_sigma(const Mat<S, MovingLayout::dim, MovingLayout::dim>& P) {
    constexpr int v = at_velocity;
    return std::sqrt(double(std::max({P(v, v), P(v + 1, v + 1), P(v + 2, v + 2)})));
  }

  /// d is log of what the prediction lacks, d = -(b - b_then) dt.
  void look_for_jump(State& x, const SE3<S>& T, const Mat<S, 6, 6>& covariance, S dt) {
    const Vec<S, 3> d = (x.T_world_body.rotation().inverse() * T.rotation()).log();
    if (!gyro_check_.update(d, (covariance(0, 0) + covariance(1, 1) + covariance(2, 2)) / S(3), dt)) return;
    turned_wrongly_ = gyro_check_.turned_wrongly();
    x.bias_gyro -= gyro_check_.rate_error();
    x.T_world_body = T;
    gyro_check_.settle();
    jumped_since_keyframe_ = true;
  }

  /// As far as the readings show.
  bool seems_at_rest(TimeNs t_ns) {
    StandstillOptions options = options_.standstill;
    const double slack = at_rest_ ? options_.rest_hysteresis : 1;
    options.gyro_spread *= slack;
    options.accel_spread *= slack;
    rest_ = standstill(imu_.buffer(), imu_.time_of(t_ns), options, options_.gravity);
    return rest_.at_rest();
  }

  Options options_;
  SE3<S> T_body_cam_calibrated_;
  Vec<S, 3> gravity_;
  ImuIntake<S> imu_;
  Preintegration<S> since_keyframe_;
  CameraImuFilter camera_imu_;
  CameraClock<S> clock_;
  Vec<S, 3> angular_rate_ = zeros<S, 3>();         ///< in this frame [rad/s]
  Vec<S, 3> angular_rate_before_ = zeros<S, 3>();  ///< in the one before
  double velocity_sigma_;                          ///< of the latest state, taken for larger [m/s]
  double solved_velocity_sigma_ = 0;               ///< of the last one solved for, as the window has it
  double speed_ = 0, speed_sigma_ = 0;             ///< of that one [m/s]
  Vec<S, 3> place_sigma_ = zeros<S, 3>();          ///< of the predicted frame, by that [m]
  GyroscopeCheck<S> gyro_check_;
  S turned_wrongly_ = S(0);  ///< [rad]
  AccelerometerCheck<S> accel_check_;
  State before_, foretold_;  ///< of the predicted frame: the state before, and what the readings make of it
  StandstillReport rest_;
  bool is_metric_ = false, blind_since_keyframe_ = false, jumped_since_keyframe_ = false, at_rest_ = false;
  bool links_disagree_ = false;
  bool knows_place_ = false;  ///< of the predicted frame, how well
};

}  // namespace plumbline
