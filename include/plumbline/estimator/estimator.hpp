#pragma once
/// Visual odometry from a rig, feature kinds and a backend, all named in the type:
///
///   using Vio = Estimator<Rig<Rgbd<Pinhole<float>>>, Features<Points<180>>, SlidingWindow<10>>;
///   static Vio vio{rig, options};                       // every byte it will ever use
///   Result<Estimate<float>> estimate = vio.add_frame({t_ns, gray, depth});
///
/// One frame, front to back: predict, track, estimate, keyframe (detect, optimize, marginalize), publish.
/// Same input, same output, bit for bit.                                                   docs/math/window.md

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/readout_filter.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

struct MotionOptions {
  int max_iterations = 10;
  double step_tolerance = 1e-5;  ///< converged below this length of the step [rad and m]
  double chi2_gate = 13.8;       ///< 99.9 % of two degrees of freedom
  int min_inliers = 8;           ///< fewer are no estimate
};

struct KeyframeOptions {
  double min_tracked_ratio = 0.5;  ///< of the landmarks in sight after the last keyframe
  double max_motion_px = 80;       ///< mean motion of the landmarks since the last keyframe
};

template <class Backend, class Maps>
struct EstimatorOptions {
  MotionOptions motion;
  KeyframeOptions keyframe;
  PoseRansacOptions ransac;
  typename Backend::Options backend;
  typename Maps::Options features;
  RotationAlignmentOptions rotation;
  ReadoutOptions readout;
  double max_prediction_s = 0.5;  ///< longer gaps are not bridged by constant velocity
  int min_landmarks = 15;         ///< to start with
  int max_lost_frames = 10;       ///< tried again against the last good frame before starting anew
};

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource = NoClock>
class Estimator {
  static_assert(SensorRig<Sensors>, "plumbline: argument 1 must be a rig, e.g. Rig<Rgbd<Pinhole<float>>>");
  static_assert(!Sensors::has_imu, "plumbline: this backend has no inertial terms");
  static_assert(Sensors::has_depth, "plumbline: a camera without depth needs a two-view start");

 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;
  using Maps = typename FeatureSet::template Maps<Sensors, BackendPolicy::slots>;
  using Backend = typename BackendPolicy::template Backend<Sensors, Maps>;
  using Options = EstimatorOptions<Backend, Maps>;

  explicit Estimator(const Sensors& rig, const Options& options = {})
      : rig_(rig),
        options_(options),
        features_(options.features),
        backend_(options.backend),
        readout_(rig.vision.readout, options.readout) {}

  /// Uses one frame; its pixels are not needed after the call. An error leaves the estimator as it was.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (frame.gray.width != rig_.vision.width || frame.gray.height != rig_.vision.height)
      return Error::wrong_image_size;
    if constexpr (Sensors::has_depth) {
      const auto& depth = frame.depth;
      if (!depth.empty() && (depth.width != frame.gray.width || depth.height != frame.gray.height)) {
        return Error::wrong_image_size;
      }
    }
    if (started_ && frame.t_ns <= estimate_.t_ns) return Error::late_sample;
    const double begin = TimeSource::now();
    timing_ = {};
    if (!pyramids_[1 - last_].build(frame.gray)) return Error::wrong_image_size;
    View<Sensors> view{rig_,
                       pyramids_[last_],
                       pyramids_[1 - last_],
                       frame.depth,
                       rig_.T_body_cam(),
                       {rig_.vision.camera, rig_.vision.height, readout_.readout().value_s, Vec<S, 3>::Zero()}};

    if (!started_) {
      start(view, frame.t_ns);
    } else {
      const SE3<S> T_predicted = predict(view, frame.t_ns);
      view.shutter.set_angular_rate(angular_rate(view, T_predicted, frame.t_ns));
      track(view, T_predicted);
      timing_.track = TimeSource::now() - begin;
      const bool tracked = estimate(view, frame.t_ns);
      const double before_map = TimeSource::now();
      timing_.estimate = before_map - begin - timing_.track;
      if (tracked && needs_keyframe()) insert_keyframe(view);
      if (!tracked) lose(view, frame.t_ns);
      timing_.map = TimeSource::now() - before_map;
    }
    timing_.total = TimeSource::now() - begin;
    return estimate_;
  }

  const Estimate<S>& latest() const { return estimate_; }
  const FrameTiming& timing() const { return timing_; }
  const Maps& features() const { return features_; }
  const Backend& backend() const { return backend_; }
  const Sensors& rig() const { return rig_; }
  /// What is known of the camera's readout time by now.
  const Readout<S>& readout() const { return readout_.readout(); }

 private:
  static constexpr std::size_t thumbnail_pixels = decltype(Sensors::vision)::max_pixels >>
                                                  (2 * RigPyramid<Sensors>::levels);

  /// Constant velocity, its rotation replaced by what the images say where they say it clearly.
  SE3<S> predict(const View<Sensors>& view, TimeNs t_ns) {
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    SE3<S> T = T_good_;
    if (lost_frames_ == 0 && dt < S(options_.max_prediction_s)) T = plus(T, Vec<S, 6>(velocity_ * dt));
    const SO3<S> R_world_cam = (T_good_ * view.T_body_cam).rotation();
    const SO3<S> R_cur_prev = (T * view.T_body_cam).rotation().inverse() * R_world_cam;
    const auto& camera = rig_.vision.camera;
    thumbnail_.build(view.previous);
    rotation_.set_previous(camera, thumbnail_);
    thumbnail_.build(view.current);
    RotationAlignment<S> best = rotation_.align(camera, thumbnail_, R_cur_prev, options_.rotation);
    const RotationAlignment<S> still = rotation_.align(camera, thumbnail_, SO3<S>(), options_.rotation);
    if (still.valid && (!best.valid || still.cost < best.cost)) best = still;
    if (!best.valid) return T;
    const SO3<S> R_body_cam = view.T_body_cam.rotation();
    return SE3<S>(R_world_cam * best.R_cur_prev.inverse() * R_body_cam.inverse(), T.p());
  }

  /// Mean angular rate of the camera [rad/s, camera] since the last frame.
  Vec<S, 3> angular_rate(const View<Sensors>& view, const SE3<S>& T_world_body, TimeNs t_ns) const {
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    return view.T_body_cam.rotation().inverse() * Vec<S, 3>(minus(T_world_body, T_good_).template head<3>() / dt);
  }

  /// Follows all features and finds the rigid motion that most of them agree on.
  void track(const View<Sensors>& view, const SE3<S>& T_predicted) {
    features_.for_each([&](auto& map) { map.track(view, backend_.window(), T_good_, T_predicted); });
    T_candidate_ = T_predicted;
    features_.for_each([&](auto& map) { map.reject_outliers(view, backend_.window(), options_.ransac, T_candidate_); });
  }

  /// Motion-only estimate, then the same with every landmark aligned with its anchor. False when it is not determined.
  bool estimate(const View<Sensors>& view, TimeNs t_ns) {
    SE3<S> T = T_candidate_;
    Mat<S, 6, 6> covariance;
    if (!refine_motion(view, T, covariance)) return false;
    features_.for_each([&](auto& map) { map.align(view, backend_.window(), T); });
    if (!refine_motion(view, T, covariance)) return false;
    const S dt = S(seconds_between(estimate_.t_ns, t_ns));
    if (!readout_.known()) estimate_readout(view, T, dt);
    velocity_ = minus(T, T_good_) / dt;
    if (lost_frames_ > 0) velocity_.setZero();
    publish(t_ns, T, covariance);
    last_ = 1 - last_;
    T_good_ = T;
    lost_frames_ = 0;
    features_.for_each([](auto& map) { map.prune(); });
    return true;
  }

  /// Iteratively reweighted Gauss-Newton on the pose alone; gates outliers at the end.
  bool refine_motion(const View<Sensors>& view, SE3<S>& T, Mat<S, 6, 6>& covariance) {
    const MotionOptions& options = options_.motion;
    for_each_motion([&](auto& map, auto& terms) { terms.collect(view, map, backend_.window()); });
    DenseNormalEquations<S, 6> system;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      const BodyView<S> body(T, view.T_body_cam);
      system.reset();
      for_each_motion([&](auto&, auto& terms) { terms.accumulate(rig_, body, system); });
      Vec<S, 6> d;
      if (!system.solve(d)) return false;
      T = plus(T, d);
      if (d.norm() < S(options.step_tolerance)) break;
    }
    int inliers = 0;
    const BodyView<S> body(T, view.T_body_cam);
    for_each_motion([&](auto& map, auto& terms) { inliers += terms.gate(rig_, map, body, S(options.chi2_gate)); });
    return inliers >= options.min_inliers && system.covariance(covariance) && T.is_finite();
  }

  void estimate_readout(const View<Sensors>& view, const SE3<S>& T_world_body, S dt) {
    DenseNormalEquations<S, 7> system;
    const BodyView<S> body(T_world_body, view.T_body_cam);
    for_each_motion([&](auto&, auto& terms) { terms.accumulate(rig_, body, system); });
    const S before = readout_.readout().value_s;
    readout_.update(system, dt);
    features_.for_each([&](auto& map) { map.change_readout(readout_.readout().value_s - before); });
  }

  bool needs_keyframe() const {
    const KeyframeOptions& options = options_.keyframe;
    if (estimate_.tracked < options.min_tracked_ratio * tracked_at_keyframe_) return true;
    const int newest = backend_.window().newest();
    double motion_px = 0;
    int count = 0;
    features_.for_each([&](const auto& map) { map.add_motion_since(newest, motion_px, count); });
    return motion_px > options.max_motion_px * count;
  }

  /// Detect, optimize the window, marginalize; the frame's pose becomes the window's.
  void insert_keyframe(const View<Sensors>& view) {
    const int slot = backend_.insert(estimate_.t_ns, estimate_.T_world_body);
    features_.for_each([&](auto& map) { map.insert_keyframe(view, backend_.window(), slot); });
    backend_.optimize(rig_, features_);
    adopt_keyframe(slot);
    if (backend_.window().full()) backend_.marginalize(rig_, features_, backend_.most_redundant(mean_depth()));
  }

  void adopt_keyframe(int slot) {
    T_good_ = backend_.window()[slot].pose.value();
    estimate_.T_world_body = T_good_;
    estimate_.keyframe = true;
    if (backend_.newest_covariance(keyframe_covariance_)) estimate_.covariance = keyframe_covariance_;
    T_keyframe_ = T_good_;
    tracked_at_keyframe_ = tracked_count();
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
    started_ = tracked_count() >= options_.min_landmarks;
    estimate_.t_ns = t_ns;
    if (!started_) {
      estimate_.health = {estimate_.resets > 0 ? HealthState::lost : HealthState::initializing,
                          HealthReason::few_features};
      return;
    }
    velocity_.setZero();
    lost_frames_ = 0;
    last_ = 1 - last_;
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
    estimate_.tracked = tracked_count();
    const bool few = estimate_.tracked < 2 * options_.motion.min_inliers;
    estimate_.health = {few ? HealthState::degraded : HealthState::tracking,
                        few ? HealthReason::few_features : HealthReason::none};
  }

  int tracked_count() const {
    return features_.sum([](const auto& map) { return map.tracked_count(); });
  }
  S mean_depth() const {
    S inverse_sum = S(0);
    int count = 0;
    features_.for_each([&](const auto& map) { map.add_inverse_ranges(inverse_sum, count); });
    return count > 0 ? S(count) / inverse_sum : S(1);
  }

  template <class Map>
  using MotionTermsOf = typename Map::MotionTerms;
  void for_each_motion(auto&& visit) {
    features_.for_each(
        [&](auto& map) { visit(map, std::get<MotionTermsOf<std::remove_cvref_t<decltype(map)>>>(motion_terms_)); });
  }

  Sensors rig_;
  Options options_;
  std::array<RigPyramid<Sensors>, 2> pyramids_;
  Thumbnail<thumbnail_pixels> thumbnail_;
  RotationAligner<typename Sensors::Camera, thumbnail_pixels> rotation_;
  int last_ = 0;  ///< pyramid of the last frame that was tracked
  Maps features_;
  typename Maps::template TupleOf<MotionTermsOf> motion_terms_;
  Backend backend_;
  ReadoutFilter<S> readout_;

  bool started_ = false;
  int lost_frames_ = 0;
  int tracked_at_keyframe_ = 0;
  SE3<S> T_good_;       ///< pose of the last frame that was tracked
  SE3<S> T_candidate_;  ///< where outlier rejection sees the current frame
  SE3<S> T_keyframe_;
  Mat<S, 6, 6> keyframe_covariance_ = Mat<S, 6, 6>::Zero();
  Vec<S, 6> velocity_ = Vec<S, 6>::Zero();  ///< [rad/s, m/s], body
  Estimate<S> estimate_;
  FrameTiming timing_;
};

}  // namespace plumbline
