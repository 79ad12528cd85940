#pragma once
/// The estimator of a rig with an IMU.                                             docs/math/inertial_window.md
///
/// Start: vision alone, as in a rig without IMU (a camera without depth first needs two views apart), until its poses
/// and the IMU agree on scale, gravity, velocities and biases. Then every frame enters the window and the window is
/// solved: a frame that is no keyframe is taken out again, without a trace, when the next one comes.
///
/// Where the image is of no use (black, covered, featureless) the IMU carries the pose on, and says so.

#include <algorithm>

#include "plumbline/estimator/inertial_start.hpp"
#include "plumbline/estimator/visual_tracking.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/imu/standstill.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource>
class InertialEstimator : public VisualTracking<Sensors, FeatureSet, BackendPolicy> {
  using Base = VisualTracking<Sensors, FeatureSet, BackendPolicy>;

 public:
  using typename Base::Backend;
  using typename Base::Frame;
  using typename Base::Maps;
  using typename Base::Options;
  using typename Base::S;

  explicit InertialEstimator(const Sensors& rig, const Options& options = {})
      : Base(rig, options),
        imu_(rig.imu.limits),
        noise_(inflated(rig.imu.noise, options.fusion)),
        since_frame_(noise_),
        since_keyframe_(noise_) {}

  /// One reading, before the frame that comes after it. Between two frames the order does not matter. Errors as in
  /// ImuBuffer.
  Result<typename ImuBuffer<>::Accepted> add_imu(const ImuSample& sample) {
    const auto accepted = imu_.add(sample);
    // Images that do not come: what the buffer is about to forget is integrated before.
    if (stage_ != Stage::empty && imu_.full() && imu_[1].t_ns > integrated_ns_)
      integrate_readings(imu_[imu_.size() / 2].t_ns);
    return accepted;
  }

  /// Uses one frame; its pixels are not needed after the call. An error leaves the estimator as it was.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!this->has_right_size(frame)) return Error::wrong_image_size;
    if (stage_ != Stage::empty && frame.t_ns <= estimate_.t_ns) return Error::late_sample;
    const double begin = TimeSource::now();
    timing_ = {};
    if (!pyramids_[1 - last_].build(frame.gray)) return Error::wrong_image_size;
    if (stage_ != Stage::empty) integrate(frame.t_ns);
    integrated_ns_ = imu_time(frame.t_ns);
    between_frames_ = false;
    View<Sensors> view = this->view_of(frame, extrinsics());
    view.shutter.set_angular_rate(camera_rate());
    switch (stage_) {
      case Stage::empty: start(view, frame.t_ns); break;
      case Stage::one_view: look_for_second_view(view, frame.t_ns); break;
      case Stage::vision: follow(view, frame.t_ns); break;
      case Stage::inertial: fuse(view, frame.t_ns); break;
    }
    timing_.total = TimeSource::now() - begin;
    return estimate_;
  }

  const InitReport& init_report() const { return report_; }
  const ImuBuffer<>& imu() const { return imu_; }
  /// Whether the body stands still, as image and IMU have it.
  bool at_rest() const { return at_rest_; }

 private:
  enum class Stage : std::uint8_t { empty, one_view, vision, inertial };
  using Base::backend_;
  using Base::estimate_;
  using Base::features_;
  using Base::keyframe_slot_;
  using Base::last_;
  using Base::options_;
  using Base::pyramids_;
  using Base::rig_;
  using Base::T_good_;
  using Base::timing_;
  static constexpr std::size_t max_pairs = 512;

  static ImuNoise inflated(ImuNoise noise, const FusionOptions& options) {
    noise.gyro_density *= options.gyro_inflation;
    noise.accel_density *= options.accel_inflation;
    noise.gyro_walk *= options.walk_inflation;
    noise.accel_walk *= options.walk_inflation;
    return noise;
  }

  /// Vision alone has no use for the lever arm: its body is the camera, turned. (Without depth it has another unit.)
  SE3<S> extrinsics() const {
    const SE3<S> T_body_cam = rig_.T_body_cam();
    return stage_ == Stage::inertial ? T_body_cam : SE3<S>(T_body_cam.rotation(), Vec<S, 3>::Zero());
  }

  TimeNs imu_time(TimeNs t_ns) const { return t_ns + static_cast<TimeNs>(rig_.imu.camera_time_offset_s * 1e9); }

  /// The readings since the last frame up to that time of the IMU.
  void integrate_readings(TimeNs until_ns) {
    if (!between_frames_) {
      since_frame_ = Preintegration<S>(noise_, state_.bias_gyro, state_.bias_accel);
      coverage_ = {};
      between_frames_ = true;
    }
    coverage_ += imu_.for_each_interval(integrated_ns_, until_ns, [&](const ImuInterval<double>& interval) {
      since_frame_.add(interval.template cast<S>());
    });
    imu_.mark_used(until_ns);
    integrated_ns_ = until_ns;
  }

  void integrate(TimeNs t_ns) {
    integrate_readings(imu_time(t_ns));
    since_keyframe_.append(since_frame_);
    blind_since_keyframe_ = blind_since_keyframe_ || blind();
    S duration = since_frame_.increment().duration;
    if (!(duration > S(0))) duration = S(seconds_between(estimate_.t_ns, t_ns));
    body_rate_ = since_frame_.increment().delta.dR.log() / duration;
  }
  bool missing() const { return !(coverage_.missing() < 0.5); }
  /// Whether the readings since the last frame say nothing about the translation.
  bool blind() const { return missing() || coverage_.saturated_s > 0; }

  Vec<S, 3> camera_rate() const { return rig_.T_body_cam().rotation().inverse() * body_rate_; }

  // ------------------------------------------------------------------------------------------------- start

  /// The first keyframe of a window.
  void start(const View<Sensors>& view, TimeNs t_ns) {
    features_.for_each([](auto& map) { map.clear(); });
    const int slot = backend_.start(t_ns, SE3<S>());
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    since_keyframe_ = Preintegration<S>(noise_, state_.bias_gyro, state_.bias_accel);
    alignment_.clear();
    velocity_.setZero();
    stage_ = Stage::empty;
    report_ = {.rejected = report_.rejected};
    estimate_.t_ns = t_ns;
    estimate_.keyframe = false;
    estimate_.tracked = 0;
    report_.features = feature_count();
    if (report_.features < options_.min_landmarks) {
      initializing(HealthReason::few_features, InitStage::few_features);
      return;
    }
    this->keep_image(view, SE3<S>());
    adopt_keyframe(slot);
    stage_ = Sensors::has_depth ? Stage::vision : Stage::one_view;
    initializing(HealthReason::aligning, Sensors::has_depth ? InitStage::aligning : InitStage::little_parallax);
    one_view_ns_ = t_ns;
    alignment_.add(SE3<S>(rig_.T_body_cam().rotation(), Vec<S, 3>::Zero()), since_keyframe_, 0);
  }

  void initializing(HealthReason reason, InitStage stage) {
    estimate_.health = {estimate_.resets > 0 ? HealthState::lost : HealthState::initializing, reason};
    report_.stage = stage;
  }

  int feature_count() const {
    int n = 0;
    features_.for_each([&](const auto& map) {
      for (const auto& landmark : map.landmarks()) n += landmark.current.valid;
    });
    return n;
  }

  /// Follows the corners of the first view until a second one sees them from far enough aside.
  void look_for_second_view(const View<Sensors>& view, TimeNs t_ns) {
    const SO3<S> dR = since_frame_.increment().delta.dR;
    const SE3<S> T_predicted(T_good_.rotation() * dR, Vec<S, 3>::Zero());
    features_.for_each([&](auto& map) { map.track(view, backend_.window(), T_good_, T_predicted); });
    estimate_.t_ns = t_ns;
    this->keep_image(view, T_predicted);
    pairs_.clear();
    const auto take = [this](const Vec<S, 3>& f1, const Vec<S, 3>& f2) { pairs_.push_back({f1, f2}); };
    features_.for_each([&, slot = keyframe_slot_](auto& map) {
      if constexpr (requires { map.for_each_pair(view, slot, take); }) map.for_each_pair(view, slot, take);
      map.prune();
    });
    report_.features = static_cast<int>(pairs_.size());
    const InertialStartOptions& options = options_.fusion.start;
    at_rest_ = finds_rest(t_ns);
    // Tracks creep by themselves: before that looks like motion, the first view is taken again.
    const bool crept = at_rest_ && this->mean_motion_px(keyframe_slot_) > options_.fusion.rest_motion_px;
    initializing(HealthReason::aligning, InitStage::little_parallax);
    if (crept || report_.features < options.min_pairs || seconds_between(one_view_ns_, t_ns) > options.max_start_s) {
      start(view, t_ns);
    }
    if (at_rest_) rest();
    if (at_rest_ || stage_ == Stage::empty || one_view_ns_ == t_ns) return;
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
    alignment_.add(T_good_ * view.T_body_cam, since_frame_, 0);
  }

  /// Standing still before the start: all is known but the scale of what is seen. The world is the one that the window
  /// will have, see try_to_align.
  void rest() {
    state_ = state_at_rest<S>(rest_, options_.backend.inertial.gravity);
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
    SE3<S> T(T_good_.rotation() * since_frame_.increment().delta.dR, T_good_.p() + dt * velocity_);
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
    const bool new_pose = alignment_.add(T * view.T_body_cam, since_frame_, options_.fusion.start.frame_interval_s);
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
    adopt_keyframe(slot);
    // In order of time, so that the chain stays whole.
    if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
  }

  void adopt_keyframe(int slot) {
    keyframe_slot_ = slot;
    this->tracked_at_keyframe_ = this->tracked_count();
    since_keyframe_ = Preintegration<S>(noise_, state_.bias_gyro, state_.bias_accel);
    blind_since_keyframe_ = false;
    estimate_.keyframe = true;
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
    adopt_state(keyframe_slot_);
    if (!believed()) {
      state_ = before;
      ++report_.rejected;
      start(view, t_ns);
      report_.stage = InitStage::not_believed;
      return;
    }
    T_good_ = state_.T_world_body;
    since_keyframe_ = Preintegration<S>(noise_, state_.bias_gyro, state_.bias_accel);
    report_.stage = InitStage::done;
    report_.done_ns = good_ns_ = t_ns;
    publish(t_ns);
  }

  /// Whether images and readings, solved for together, bear out what was aligned: poses of a wrong scene can be aligned
  /// with the readings of half a second, but then need an accelerometer bias that no sensor has.
  bool believed() const {
    const double largest = double(state_.bias_accel.cwiseAbs().maxCoeff());
    return largest <= options_.fusion.start.max_accel_bias_sigmas * options_.backend.inertial.start_accel_bias_sigma;
  }

  // ------------------------------------------------------------------------------------------------- window

  /// Where the readings put the frame; where they say nothing (missing, saturated), constant velocity and the rotation
  /// that the images show.
  NavState<S> predict(const View<Sensors>& view, TimeNs t_ns) {
    const auto& increment = since_frame_.increment();
    if (!blind()) return increment.predict(state_, backend_.inertial().gravity());
    NavState<S> x = state_;
    SO3<S> R_previous_now = increment.corrected(x.bias_gyro, x.bias_accel).dR;
    if (missing() || coverage_.gyro_saturated_s > 0) {
      const SO3<S> R_body_cam = view.T_body_cam.rotation();
      const RotationAlignment<S> seen = this->align_rotation(view, SO3<S>());
      R_previous_now = seen.valid ? R_body_cam * seen.R_cur_prev.inverse() * R_body_cam.inverse() : SO3<S>();
    }
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    x.T_world_body = SE3<S>(T_good_.rotation() * R_previous_now, x.T_world_body.p() + dt * x.v_world_body);
    return x;
  }

  /// One frame into the window.
  void fuse(const View<Sensors>& view, TimeNs t_ns) {
    const double begin = TimeSource::now();
    NavState<S> x = predict(view, t_ns);
    const S dt = since_frame_.increment().duration;
    const FusionOptions& options = options_.fusion;
    PosePrior<S> prior{x.T_world_body, Vec<S, 6>::Zero()};
    const auto& S15 = since_frame_.increment().covariance;
    const S blind_s = S(seconds_between(good_ns_, t_ns));  // the velocity gets worse while the image is of no use
    for (int k = 0; k < 3; ++k) {
      prior.sigma[k] = S(std::hypot(options.rotation_sigma, std::sqrt(double(S15(k, k)))));
      prior.sigma[k + 3] =
          S(std::hypot(options.velocity_sigma * double(blind_s), std::sqrt(double(S15(k + 3, k + 3)))));
    }
    SE3<S> T = this->track(view, x.T_world_body);
    timing_.track = TimeSource::now() - begin;
    Mat<S, 6, 6> covariance;
    const bool seen = this->find_motion(view, &prior, T, covariance);
    if (!seen) {
      coast(view, x, t_ns);
      return;
    }
    this->estimate_readout(view, T, dt);
    timing_.estimate = TimeSource::now() - begin - timing_.track;

    drop_temporary();
    at_rest_ = finds_rest(t_ns);
    // A link that was blind somewhere ends as soon as the readings are back: the next one tells the velocity.
    const bool keyframe = (this->needs_keyframe() || (blind_since_keyframe_ && !blind())) && !at_rest_;
    if (blind()) x.T_world_body = T;
    const int slot = backend_.insert(t_ns, x, keyframe_slot_, since_keyframe_, at_rest_);
    features_.for_each([&](auto& map) {
      if (keyframe) {
        map.insert_keyframe(view, backend_.window(), slot);
      } else {
        map.record(slot);
      }
    });
    LevenbergMarquardtOptions solver = options_.backend.solver;
    if (!keyframe) solver.max_iterations = options.frame_iterations;
    backend_.optimize(rig_, view.T_body_cam, features_, solver);
    const Vec<S, 3> p_before = state_.T_world_body.p();
    adopt_state(slot);
    if (blind_since_keyframe_) state_.v_world_body = (state_.T_world_body.p() - p_before) / dt;  // by the images
    this->keep_image(view, state_.T_world_body);
    features_.for_each([&](auto& map) {
      map.triangulate(view, backend_.window(), state_.T_world_body);
      map.prune();
    });
    good_ns_ = t_ns;
    blind_frames_ = 0;
    publish(t_ns);
    if (keyframe) {
      adopt_keyframe(slot);
      if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
    } else {
      temporary_slot_ = slot;
    }
    timing_.map = TimeSource::now() - begin - timing_.track - timing_.estimate;
  }

  /// The image does not give a pose: the IMU alone.
  void coast(const View<Sensors>& view, const NavState<S>& x, TimeNs t_ns) {
    state_ = x;
    at_rest_ = false;
    if (feature_count() >= options_.min_landmarks) {  // followed, and located as soon as there is parallax
      this->keep_image(view, x.T_world_body);
      features_.for_each([&](auto& map) {
        map.triangulate(view, backend_.window(), x.T_world_body);
        map.prune();
      });
    } else {
      features_.for_each([](auto& map) { map.undo_frame(); });
      if (++blind_frames_ > options_.fusion.max_blind_frames) look_anew(view, t_ns);
    }
    const Mat<S, 6, 6> before = estimate_.covariance;
    publish(t_ns);
    const S dt = since_frame_.increment().duration;
    estimate_.covariance = before + since_frame_.increment().covariance.template topLeftCorner<6, 6>();
    estimate_.covariance.diagonal().template tail<3>().array() +=
        S(options_.fusion.velocity_sigma * options_.fusion.velocity_sigma) * dt;
    estimate_.tracked = 0;
    const double blind_s = seconds_between(good_ns_, t_ns);
    const bool lost = !(blind_s < options_.fusion.max_coasting_s);
    estimate_.health = {lost ? HealthState::lost : HealthState::degraded, HealthReason::coasting};
  }

  /// What was seen before is out of sight: a keyframe at the predicted pose, if the image shows corners at all.
  void look_anew(const View<Sensors>& view, TimeNs t_ns) {
    drop_temporary();
    const int slot = backend_.insert(t_ns, state_, keyframe_slot_, since_keyframe_, false);
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    if (feature_count() < options_.min_landmarks) {
      backend_.drop(features_, slot);
      return;
    }
    blind_frames_ = 0;
    this->keep_image(view, state_.T_world_body);
    adopt_keyframe(slot);
    if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
  }

  void drop_temporary() {
    if (temporary_slot_ >= 0) backend_.drop(features_, temporary_slot_);
    temporary_slot_ = -1;
  }

  void adopt_state(int slot) { state_ = backend_.state(slot); }

  /// Nothing moved since the last keyframe, by image and IMU. Rest is left less easily than it is entered.
  bool finds_rest(TimeNs t_ns) {
    StandstillOptions options = options_.fusion.standstill;
    const double slack = at_rest_ ? options_.fusion.rest_hysteresis : 1;
    options.gyro_spread *= slack;
    options.accel_spread *= slack;
    if (!(this->mean_motion_px(keyframe_slot_) < slack * options_.fusion.rest_motion_px)) return false;
    rest_ = standstill(imu_, imu_time(t_ns), options);
    return rest_.at_rest();
  }

  void publish(TimeNs t_ns) {
    estimate_.t_ns = t_ns;
    estimate_.T_world_body = state_.T_world_body;
    estimate_.v_world_body = state_.v_world_body;
    estimate_.bias_gyro = state_.bias_gyro;
    estimate_.bias_accel = state_.bias_accel;
    estimate_.keyframe = false;
    estimate_.tracked = this->tracked_count();
    estimate_.health = this->health_of_tracking();
    if (backend_.inertial().disagreement(backend_.window()) > options_.fusion.max_disagreement)
      estimate_.health = {HealthState::degraded, HealthReason::imu_disagrees};
    if (coverage_.saturated_s > 0) estimate_.health = {HealthState::degraded, HealthReason::imu_saturated};
    if (missing()) estimate_.health = {HealthState::degraded, HealthReason::no_imu_data};
    Mat<S, 6, 6> covariance;
    if (backend_.newest_covariance(covariance)) estimate_.covariance = covariance;
  }

  ImuBuffer<> imu_;
  ImuNoise noise_;
  Stage stage_ = Stage::empty;
  NavState<S> state_;  ///< of the latest frame
  Preintegration<S> since_frame_, since_keyframe_;
  ImuCoverage coverage_;         ///< of the time since the last frame
  TimeNs integrated_ns_ = 0;     ///< readings are integrated up to there
  bool between_frames_ = false;  ///< some of them since the last frame
  bool blind_since_keyframe_ = false;
  Vec<S, 3> body_rate_ = Vec<S, 3>::Zero();
  Vec<S, 3> velocity_ = Vec<S, 3>::Zero();  ///< of vision alone, in its own unit
  int temporary_slot_ = -1;                 ///< of the latest frame when it is no keyframe
  StandstillReport rest_;
  bool at_rest_ = false;
  int blind_frames_ = 0;    ///< in a row whose image was of no use
  TimeNs good_ns_ = 0;      ///< of the last frame whose image was of use
  TimeNs one_view_ns_ = 0;  ///< of the first of two views
  InitReport report_;
  AlignmentWindow<S> alignment_;
  FixedVector<BearingPair<S>, max_pairs> pairs_;
  TwoViewSolver<S, max_pairs> two_view_;
};

}  // namespace plumbline
