#pragma once
/// The estimator of a rig with an IMU.                                             docs/math/inertial_window.md
///
/// Once started, every frame enters the window and the window is solved: a frame that is no keyframe is taken out
/// again, without a trace, when the next one comes. Where the image is of no use (black, covered, featureless) the IMU
/// carries the pose on, and says so.

#include <algorithm>

#include "plumbline/estimator/inertial_starter.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource>
class InertialEstimator : public InertialStarter<Sensors, FeatureSet, BackendPolicy> {
  using Base = InertialStarter<Sensors, FeatureSet, BackendPolicy>;

 public:
  using typename Base::Frame;
  using typename Base::Options;
  using typename Base::S;

  explicit InertialEstimator(const Sensors& rig, const Options& options = {}) : Base(rig, options) {}

  /// One reading, before the frame that comes after it. Between two frames the order does not matter. Errors as in
  /// ImuBuffer.
  Result<typename ImuBuffer<>::Accepted> add_imu(const ImuSample& sample) {
    return imu_.add(sample, has_frame() ? &state_ : nullptr);
  }

  /// Uses one frame; its pixels are not needed after the call. An error leaves the estimator as it was.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!this->has_right_size(frame)) return Error::wrong_image_size;
    if (has_frame() && frame.t_ns <= estimate_.t_ns) return Error::late_sample;
    const double begin = TimeSource::now();
    timing_ = {};
    if (!pyramids_[1 - last_].build(frame.gray)) return Error::wrong_image_size;
    if (has_frame()) this->integrate(frame.t_ns);
    imu_.begin_frame(frame.t_ns);
    View<Sensors> view = this->view_of(frame, extrinsics());
    view.shutter.set_angular_rate(rig_.T_body_cam().rotation().inverse() * this->body_rate_);
    if (this->stage() == Stage::inertial) {
      fuse(view, frame.t_ns);
    } else {
      this->start_with(view, frame.t_ns);
    }
    timing_.total = TimeSource::now() - begin;
    return estimate_;
  }

 private:
  using Base::backend_;
  using Base::blind_since_keyframe_;
  using Base::estimate_;
  using Base::features_;
  using Base::good_ns_;
  using Base::imu_;
  using Base::keyframe_slot_;
  using Base::last_;
  using Base::options_;
  using Base::pyramids_;
  using Base::rig_;
  using Base::since_keyframe_;
  using Base::state_;
  using Base::T_good_;
  using Base::timing_;
  using typename Base::Stage;

  bool has_frame() const { return this->stage() != Stage::empty; }

  /// Vision alone has no use for the lever arm: its body is the camera, turned. (Without depth it has another unit.)
  SE3<S> extrinsics() const {
    const SE3<S> T_body_cam = rig_.T_body_cam();
    return this->stage() == Stage::inertial ? T_body_cam : SE3<S>(T_body_cam.rotation(), Vec<S, 3>::Zero());
  }

  /// Where the readings put the frame; where they say nothing (missing, saturated), constant velocity and the rotation
  /// that the images show.
  NavState<S> predict(const View<Sensors>& view, TimeNs t_ns) {
    const auto& increment = imu_.since_frame().increment();
    if (!imu_.blind()) return increment.predict(state_, backend_.inertial().gravity());
    NavState<S> x = state_;
    SO3<S> R_previous_now = increment.corrected(x.bias_gyro, x.bias_accel).dR;
    if (imu_.missing() || imu_.coverage().gyro_saturated_s > 0) {
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
    const S dt = imu_.since_frame().increment().duration;
    const FusionOptions& options = options_.fusion;
    PosePrior<S> prior{x.T_world_body, Vec<S, 6>::Zero()};
    const auto& S15 = imu_.since_frame().increment().covariance;
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
    this->at_rest_ = this->finds_rest(t_ns);
    // A link that was blind somewhere ends as soon as the readings are back: the next one tells the velocity.
    const bool keyframe = (this->needs_keyframe() || (blind_since_keyframe_ && !imu_.blind())) && !this->at_rest_;
    if (imu_.blind()) x.T_world_body = T;
    const int slot = backend_.insert(t_ns, x, keyframe_slot_, since_keyframe_, this->at_rest_);
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
    this->adopt_state(slot);
    if (blind_since_keyframe_) state_.v_world_body = (state_.T_world_body.p() - p_before) / dt;  // by the images
    this->keep_image(view, state_.T_world_body);
    features_.for_each([&](auto& map) {
      map.triangulate(view, backend_.window(), state_.T_world_body);
      map.prune();
    });
    good_ns_ = t_ns;
    blind_frames_ = 0;
    this->publish(t_ns);
    if (keyframe) {
      this->adopt_keyframe(slot);
      if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
    } else {
      temporary_slot_ = slot;
    }
    timing_.map = TimeSource::now() - begin - timing_.track - timing_.estimate;
  }

  /// The image does not give a pose: the IMU alone.
  void coast(const View<Sensors>& view, const NavState<S>& x, TimeNs t_ns) {
    state_ = x;
    this->at_rest_ = false;
    if (this->feature_count() >= options_.min_landmarks) {  // followed, and located as soon as there is parallax
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
    this->publish(t_ns);
    const auto& increment = imu_.since_frame().increment();
    estimate_.covariance = before + block<6, 6>(increment.covariance, 0, 0);
    const S walk = S(options_.fusion.velocity_sigma * options_.fusion.velocity_sigma) * increment.duration;
    for (int k = 3; k < 6; ++k) estimate_.covariance(k, k) += walk;
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
    if (this->feature_count() < options_.min_landmarks) {
      backend_.drop(features_, slot);
      return;
    }
    blind_frames_ = 0;
    this->keep_image(view, state_.T_world_body);
    this->adopt_keyframe(slot);
    if (backend_.window().full()) backend_.marginalize(rig_, view.T_body_cam, features_, backend_.oldest());
  }

  void drop_temporary() {
    if (temporary_slot_ >= 0) backend_.drop(features_, temporary_slot_);
    temporary_slot_ = -1;
  }

  int temporary_slot_ = -1;  ///< of the latest frame when it is no keyframe
  int blind_frames_ = 0;     ///< in a row whose image was of no use
};

}  // namespace plumbline
