#pragma once
/// The estimator of a rig without IMU.                                                     docs/math/window.md
///
/// Every frame is estimated alone with its map given; a keyframe makes the window solve, which corrects the map.

#include "plumbline/estimator/visual_tracking.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource>
class VisualEstimator : public VisualTracking<Sensors, FeatureSet, BackendPolicy> {
  static_assert(Sensors::has_depth, "plumbline: a camera without depth and without IMU needs a two-view start");
  using Base = VisualTracking<Sensors, FeatureSet, BackendPolicy>;

 public:
  using typename Base::Frame;
  using typename Base::Options;
  using typename Base::S;

  explicit VisualEstimator(const Sensors& rig, const Options& options = {}) : Base(rig, options) {}

  /// Uses one frame; its pixels are not needed after the call. An error leaves the estimator as it was.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!this->has_right_size(frame)) return Error::wrong_image_size;
    if (started_ && frame.t_ns <= estimate_.t_ns) return Error::late_sample;
    const double begin = TimeSource::now();
    timing_ = {};
    if (!pyramids_[1 - last_].build(frame.gray)) return Error::wrong_image_size;
    View<Sensors> view = this->view_of(frame, rig_.T_body_cam());

    if (!started_) {
      start(view, frame.t_ns);
    } else {
      const SE3<S> T_predicted = predict(view, frame.t_ns);
      view.shutter.set_angular_rate(angular_rate(view, T_predicted, frame.t_ns));
      const SE3<S> T_candidate = this->track(view, T_predicted);
      timing_.track = TimeSource::now() - begin;
      const bool tracked = estimate(view, frame.t_ns, T_candidate);
      const double before_map = TimeSource::now();
      timing_.estimate = before_map - begin - timing_.track;
      if (tracked && this->needs_keyframe()) insert_keyframe(view);
      if (!tracked) lose(view, frame.t_ns);
      timing_.map = TimeSource::now() - before_map;
    }
    timing_.total = TimeSource::now() - begin;
    return estimate_;
  }

 private:
  using Base::backend_;
  using Base::estimate_;
  using Base::features_;
  using Base::last_;
  using Base::options_;
  using Base::pyramids_;
  using Base::rig_;
  using Base::T_good_;
  using Base::timing_;

  /// Constant velocity, its rotation replaced by what the images say where they say it clearly.
  SE3<S> predict(const View<Sensors>& view, TimeNs t_ns) {
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    SE3<S> T = T_good_;
    if (lost_frames_ == 0 && dt < S(options_.max_prediction_s)) T = plus(T, Vec<S, 6>(velocity_ * dt));
    const SO3<S> R_world_cam = (T_good_ * view.T_body_cam).rotation();
    const SO3<S> R_cur_prev = (T * view.T_body_cam).rotation().inverse() * R_world_cam;
    const RotationAlignment<S> seen = this->align_rotation(view, R_cur_prev);
    if (!seen.valid) return T;
    const SO3<S> R_body_cam = view.T_body_cam.rotation();
    return SE3<S>(R_world_cam * seen.R_cur_prev.inverse() * R_body_cam.inverse(), T.p());
  }

  /// Mean angular rate of the camera [rad/s, camera] since the last frame.
  Vec<S, 3> angular_rate(const View<Sensors>& view, const SE3<S>& T_world_body, TimeNs t_ns) const {
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    return view.T_body_cam.rotation().inverse() * Vec<S, 3>(minus(T_world_body, T_good_).template head<3>() / dt);
  }

  bool estimate(const View<Sensors>& view, TimeNs t_ns, SE3<S> T) {
    Mat<S, 6, 6> covariance;
    if (!this->find_motion(view, nullptr, T, covariance)) return false;
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    this->estimate_readout(view, T, dt);
    velocity_ = minus(T, T_good_) / dt;
    if (lost_frames_ > 0) velocity_.setZero();
    publish(t_ns, T, covariance);
    this->keep_image(view, T);
    lost_frames_ = 0;
    features_.for_each([&](auto& map) {
      map.triangulate(view, backend_.window(), T);
      map.prune();
    });
    return true;
  }

  /// Detect, optimize the window, marginalize; the frame's pose becomes the window's.
  void insert_keyframe(const View<Sensors>& view) {
    const int slot = backend_.insert(estimate_.t_ns, estimate_.T_world_body);
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    backend_.optimize(rig_, features_);
    adopt_keyframe(slot);
    if (backend_.window().full()) backend_.marginalize(rig_, features_, backend_.most_redundant(this->mean_depth()));
  }

  void adopt_keyframe(int slot) {
    T_good_ = backend_.window()[slot].pose.value();
    estimate_.T_world_body = T_good_;
    estimate_.keyframe = true;
    if (backend_.newest_covariance(keyframe_covariance_)) estimate_.covariance = keyframe_covariance_;
    T_keyframe_ = T_good_;
    this->keyframe_slot_ = slot;
    this->tracked_at_keyframe_ = this->tracked_count();
  }

  /// The pose could not be estimated: the next frames are tried against the last good one, then the window starts anew.
  void lose(const View<Sensors>& view, TimeNs t_ns) {
    estimate_.t_ns = t_ns;
    estimate_.keyframe = false;
    estimate_.tracked = 0;
    estimate_.health = {HealthState::lost, HealthReason::few_inliers};
    if (++lost_frames_ <= options_.max_lost_frames) {
      features_.for_each([](auto& map) { map.undo_frame(); });
      return;
    }
    ++estimate_.resets;
    start(view, t_ns);
  }

  /// The first keyframe of a window, at the last known pose.
  void start(const View<Sensors>& view, TimeNs t_ns) {
    features_.for_each([](auto& map) { map.clear(); });
    const int slot = backend_.start(t_ns, T_good_);
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    started_ = this->tracked_count() >= options_.min_landmarks;
    estimate_.t_ns = t_ns;
    if (!started_) {
      estimate_.health = {estimate_.resets > 0 ? HealthState::lost : HealthState::initializing,
                          HealthReason::few_features};
      return;
    }
    velocity_.setZero();
    lost_frames_ = 0;
    this->keep_image(view, T_good_);
    publish(t_ns, T_good_, Mat<S, 6, 6>::Zero());
    adopt_keyframe(slot);
  }

  void publish(TimeNs t_ns, const SE3<S>& T, const Mat<S, 6, 6>& motion_covariance) {
    estimate_.t_ns = t_ns;
    estimate_.T_world_body = T;
    // The keyframe's uncertainty, carried over to this body, plus that of the motion since.
    const Mat<S, 6, 6> Ad = (T.inverse() * T_keyframe_).adjoint();
    estimate_.covariance = Ad * keyframe_covariance_ * Ad.transpose() + motion_covariance;
    estimate_.keyframe = false;
    estimate_.tracked = this->tracked_count();
    estimate_.health = this->health_of_tracking();
  }

  bool started_ = false;
  int lost_frames_ = 0;
  SE3<S> T_keyframe_;
  Mat<S, 6, 6> keyframe_covariance_ = Mat<S, 6, 6>::Zero();
  Vec<S, 6> velocity_ = Vec<S, 6>::Zero();  ///< [rad/s, m/s], body
};

}  // namespace plumbline
