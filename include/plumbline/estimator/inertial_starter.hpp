#pragma once
/// The start of an estimator with an IMU: vision alone, as in a rig without IMU (a camera without depth first needs two
/// views apart), until its poses and the IMU agree on scale, gravity, velocities and biases.
///                                                                                docs/math/inertial_window.md

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/estimator/inertial_start.hpp"
#include "plumbline/estimator/inertial_tracking.hpp"
#include "plumbline/geometry/two_view.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy>
class InertialStarter : public InertialTracking<Sensors, FeatureSet, BackendPolicy> {
  using Base = InertialTracking<Sensors, FeatureSet, BackendPolicy>;
  static_assert(Sensors::has_depth || Base::Maps::relates_two_views,
                "plumbline: a camera without depth starts by points, e.g. Features<StartPoints<200>, Lines<100>>");

 public:
  using typename Base::Options;
  using typename Base::S;

  const InitReport& init_report() const { return report_; }

 protected:
  enum class Stage : std::uint8_t { empty, one_view, vision, inertial };
  using Base::backend_;
  using Base::estimate_;
  using Base::features_;
  using Base::imu_;
  using Base::keyframe_slot_;
  using Base::options_;
  using Base::rig_;
  using Base::since_keyframe_;
  using Base::state_;
  using Base::T_good_;

  using Base::Base;

  Stage stage() const { return stage_; }

  /// One frame before the inertial stage.
  void start_with(const View<Sensors>& view, TimeNs t_ns) {
    switch (stage_) {
      case Stage::empty: return start(view, t_ns);
      case Stage::one_view: return look_for_second_view(view, t_ns);
      default: return follow(view, t_ns);
    }
  }

 private:
  static constexpr std::size_t max_pairs = 512;

  /// The first keyframe of a window.
  void start(const View<Sensors>& view, TimeNs t_ns) {
    features_.for_each([](auto& map) { map.clear(); });
    const int slot = backend_.start(t_ns, SE3<S>());
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    since_keyframe_ = imu_.since(state_);
    alignment_.clear();
    velocity_.setZero();
    stage_ = Stage::empty;
    report_ = {.rejected = report_.rejected};
    estimate_.t_ns = t_ns;
    estimate_.keyframe = false;
    estimate_.tracked = 0;
    report_.features = this->feature_count();
    if (report_.features < options_.min_landmarks) {
      initializing(HealthReason::few_features, InitStage::few_features);
      return;
    }
    this->keep_image(view, SE3<S>());
    this->adopt_keyframe(slot);
    stage_ = Sensors::has_depth ? Stage::vision : Stage::one_view;
    initializing(HealthReason::aligning, Sensors::has_depth ? InitStage::aligning : InitStage::little_parallax);
    one_view_ns_ = t_ns;
    alignment_.add(SE3<S>(rig_.T_body_cam().rotation(), Vec<S, 3>::Zero()), since_keyframe_, 0);
  }

  void initializing(HealthReason reason, InitStage stage) {
    estimate_.health = {estimate_.resets > 0 ? HealthState::lost : HealthState::initializing, reason};
    report_.stage = stage;
  }

  /// Follows the corners of the first view until a second one sees them from far enough aside.
  void look_for_second_view(const View<Sensors>& view, TimeNs t_ns) {
    const SO3<S> dR = imu_.since_frame().increment().delta.dR;
    const SE3<S> T_predicted(T_good_.rotation() * dR, Vec<S, 3>::Zero());
    features_.for_each([&](auto& map) { map.track(view, backend_.window(), T_good_, T_predicted); });
    estimate_.t_ns = t_ns;
    this->keep_image(view, T_predicted);
    pairs_.clear();
    const auto take = [this](const Vec<S, 3>& f1, const Vec<S, 3>& f2) { pairs_.push_back({f1, f2}); };
    features_.for_each([&, slot = keyframe_slot_](auto& map) {
      if constexpr (requires { map.relates_two_views; }) map.for_each_pair(view, slot, take);
      map.prune();
    });
    report_.features = static_cast<int>(pairs_.size());
    const InertialStartOptions& options = options_.fusion.start;
    this->at_rest_ = this->finds_rest(t_ns);
    // Tracks creep by themselves: before that looks like motion, the first view is taken again.
    const bool crept = this->at_rest_ && this->mean_motion_px(keyframe_slot_) > options_.fusion.rest_motion_px;
    initializing(HealthReason::aligning, InitStage::little_parallax);
    if (crept || report_.features < options.min_pairs || seconds_between(one_view_ns_, t_ns) > options.max_start_s) {
      start(view, t_ns);
    }
    if (this->at_rest_) rest();
    if (this->at_rest_ || stage_ == Stage::empty || one_view_ns_ == t_ns) return;
    const SO3<S> R_body_cam = view.T_body_cam.rotation();
    const SO3<S> R_2_1 = (T_predicted.rotation() * R_body_cam).inverse() * R_body_cam;
    const TwoView<S, max_pairs> found = two_view_.solve(pairs_, R_2_1, options.two_view);
    report_.parallax_rad = double(found.parallax);
    report_.inliers = double(found.inliers) / double(pairs_.size());
    if (!found.valid || !(report_.parallax_rad > options.min_parallax_rad)) return;
    if (!(double(found.in_front) > options.min_inliers * double(pairs_.size()))) {
      report_.stage = InitStage::two_views_disagree;
      return;
    }
    // The unit of length: the distance between the two views is a fifth of it, so that most points are some units away.
    const SE3<S> T_1_2 = found.T_2_1.inverse();
    const SE3<S> T_world_cam(R_body_cam * T_1_2.rotation(), R_body_cam * Vec<S, 3>(S(0.2) * T_1_2.p()));
    const SE3<S> T_world_body = T_world_cam * view.T_body_cam.inverse();
    features_.for_each([&](auto& map) { map.triangulate(view, backend_.window(), T_world_body); });
    stage_ = Stage::vision;
    estimate_.T_world_body = T_good_ = T_world_body;
    insert_visual_keyframe(view, t_ns);
    report_.stage = InitStage::aligning;
    alignment_.clear();
    alignment_.add(T_good_ * view.T_body_cam, imu_.since_frame(), 0);
  }

  /// Standing still before the start: all is known but the scale of what is seen. The world is the one that the window
  /// will have, see try_to_align.
  void rest() {
    state_ = state_at_rest<S>(this->rest_, options_.backend.inertial.gravity);
    estimate_.T_world_body = state_.T_world_body;
    estimate_.v_world_body.setZero();
    estimate_.bias_gyro = state_.bias_gyro;
    estimate_.bias_accel = state_.bias_accel;
    const S tilt = S(options_.backend.inertial.start_accel_bias_sigma / options_.backend.inertial.gravity);
    const S position = S(options_.backend.inertial.rest_position_sigma);
    estimate_.covariance = (Vec<S, 6>() << Vec<S, 3>::Constant(tilt * tilt), Vec<S, 3>::Constant(position * position))
                               .finished()
                               .asDiagonal();
    estimate_.health = {HealthState::degraded, HealthReason::aligning};
  }

  /// One frame of vision alone.
  void follow(const View<Sensors>& view, TimeNs t_ns) {
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    SE3<S> T(T_good_.rotation() * imu_.since_frame().increment().delta.dR, T_good_.p() + dt * velocity_);
    T = this->track(view, T);
    Mat<S, 6, 6> covariance;
    if (!this->find_motion(view, nullptr, T, covariance)) {
      start(view, t_ns);
      return;
    }
    this->estimate_readout(view, T, dt);
    velocity_ = (T.p() - T_good_.p()) / dt;
    this->keep_image(view, T);
    estimate_.t_ns = t_ns;
    estimate_.T_world_body = T;
    estimate_.keyframe = false;
    estimate_.tracked = this->tracked_count();
    features_.for_each([&](auto& map) {
      map.triangulate(view, backend_.window(), T);
      map.prune();
    });
    initializing(HealthReason::aligning, InitStage::aligning);
    const bool new_pose =
        alignment_.add(T * view.T_body_cam, imu_.since_frame(), options_.fusion.start.frame_interval_s);
    if (this->needs_keyframe()) insert_visual_keyframe(view, t_ns);
    if (new_pose) try_to_align(view, t_ns);
  }

  void insert_visual_keyframe(const View<Sensors>& view, TimeNs t_ns) {
    NavState<S> x = state_;
    x.T_world_body = T_good_;
    const int slot = backend_.insert(t_ns, x, keyframe_slot_, since_keyframe_, false);
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    backend_.optimize(rig_, view.T_body_cam, features_, options_.backend.solver);
    T_good_ = estimate_.T_world_body = backend_.window()[slot].pose.value();
    this->adopt_keyframe(slot);
    // In order of time, so that the chain stays whole.
    if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
  }

  void try_to_align(const View<Sensors>& view, TimeNs t_ns) {
    InertialAlignmentOptions options = options_.fusion.start.alignment;
    options.metric = Sensors::has_depth;
    const typename AlignmentWindow<S>::Outcome found = alignment_.align(rig_.T_body_cam(), options);
    report_.alignment = found.outcome;
    report_.excitation = found.excitation;
    report_.gravity_norm = found.gravity_norm;
    report_.gyro_residual = found.gyro_residual;
    report_.scale_sigma = found.scale_sigma;
    if (!found) return;
    if (!estimate_.keyframe) insert_visual_keyframe(view, t_ns);
    features_.for_each([&](auto& map) { map.rescale(found.scale); });
    const SE3<S> T_body_cam = rig_.T_body_cam();
    const NavState<S> before = state_;
    state_.bias_gyro = found.bias_gyro;
    state_.bias_accel = found.bias_accel;
    // Positions first, then the velocities that the increments between them ask for.
    // The first body is the origin, upright and without yaw.
    const SO3<S> R_world_ref =
        upright<S>(found.R_world_ref.inverse() * gravity_in_world<S>(S(options_.backend.inertial.gravity)));
    const auto to_world = [&](const SE3<S>& T_ref_turned) {
      const SE3<S> T_ref_cam = T_ref_turned * view.T_body_cam;
      const SE3<S> T_first_body = SE3<S>(T_ref_cam.rotation(), found.scale * T_ref_cam.p()) * T_body_cam.inverse();
      return SE3<S>(R_world_ref * T_first_body.rotation(), R_world_ref * Vec<S, 3>(T_first_body.p() + T_body_cam.p()));
    };
    backend_.start_inertial([&](int slot) {
      NavState<S> x = state_;
      x.T_world_body = to_world(backend_.window()[slot].pose.value());
      return x;
    });
    backend_.guess_velocities();
    stage_ = Stage::inertial;
    LevenbergMarquardtOptions solver = options_.backend.solver;
    solver.max_iterations *= 2;
    backend_.optimize(rig_, T_body_cam, features_, solver);
    this->adopt_state(keyframe_slot_);
    if (!believed()) {
      state_ = before;
      ++report_.rejected;
      start(view, t_ns);
      report_.stage = InitStage::not_believed;
      return;
    }
    features_.for_each([](auto& map) {
      if constexpr (requires { map.end_start(); }) map.end_start();
    });
    this->tracked_at_keyframe_ = this->tracked_count();
    T_good_ = state_.T_world_body;
    since_keyframe_ = imu_.since(state_);
    report_.stage = InitStage::done;
    report_.done_ns = this->good_ns_ = t_ns;
    this->publish(t_ns);
  }

  /// Whether images and readings, solved for together, bear out what was aligned: poses of a wrong scene can be aligned
  /// with the readings of half a second, but then need an accelerometer bias that no sensor has.
  bool believed() const {
    const double largest = double(state_.bias_accel.cwiseAbs().maxCoeff());
    return largest <= options_.fusion.start.max_accel_bias_sigmas * options_.backend.inertial.start_accel_bias_sigma;
  }

  Stage stage_ = Stage::empty;
  TimeNs one_view_ns_ = 0;                  ///< of the first of two views
  Vec<S, 3> velocity_ = Vec<S, 3>::Zero();  ///< of vision alone, in its own unit
  InitReport report_;
  AlignmentWindow<S> alignment_;
  FixedVector<BearingPair<S>, max_pairs> pairs_;
  TwoViewSolver<S, max_pairs> two_view_;
};

}  // namespace plumbline
