#pragma once
/// What every estimator does with an image: pyramids, following the features, the pose of the frame with its map given.

#include <algorithm>
#include <array>
#include <cstddef>

#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/readout_filter.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

/// A belief about a frame's pose before its image is used.
template <class S>
struct PosePrior {
  SE3<S> T_world_body;
  Vec<S, 6> sigma;  ///< of [dphi, dp] [rad, m]
};

template <class Sensors, class FeatureSet, class BackendPolicy>
class VisualTracking {
 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;
  using Maps = typename FeatureSet::template Maps<Sensors, BackendPolicy::slots>;
  using Backend = typename BackendPolicy::template Backend<Sensors, Maps>;
  using Options = EstimatorOptions<Sensors, Backend, Maps>;

  const Estimate<S>& latest() const { return estimate_; }
  const FrameTiming& timing() const { return timing_; }
  const Maps& features() const { return features_; }
  const Backend& backend() const { return backend_; }
  const Sensors& rig() const { return rig_; }
  /// What is known of the camera's readout time by now.
  const Readout<S>& readout() const { return readout_.readout(); }

 protected:
  VisualTracking(const Sensors& rig, const Options& options)
      : rig_(rig),
        options_(options),
        features_(options.features),
        backend_(options.backend),
        readout_(rig.vision.readout, options.readout) {}

  bool has_right_size(const Frame& frame) const {
    if (frame.gray.width != rig_.vision.width || frame.gray.height != rig_.vision.height) return false;
    if constexpr (Sensors::has_depth) {
      const auto& depth = frame.depth;
      return depth.empty() || (depth.width == frame.gray.width && depth.height == frame.gray.height);
    }
    return true;
  }

  /// The frame beside the last one that was tracked. Its shutter does not turn yet.
  View<Sensors> view_of(const Frame& frame, const SE3<S>& T_body_cam) const {
    const auto depth = [&]() -> ImageView<const std::uint16_t> {
      if constexpr (Sensors::has_depth) return frame.depth;
      return {};
    };
    return {rig_,    pyramids_[last_], pyramids_[1 - last_],
            depth(), T_body_cam,       {rig_.vision.camera, rig_.vision.height, readout().value_s, Vec<S, 3>::Zero()}};
  }

  /// Rotation of the camera from the previous to the current image by their coarsest pixels, begun at `guess` and at
  /// rest.
  RotationAlignment<S> align_rotation(const View<Sensors>& view, const SO3<S>& guess) {
    const auto& camera = rig_.vision.camera;
    thumbnail_.build(view.previous);
    rotation_.set_previous(camera, thumbnail_);
    thumbnail_.build(view.current);
    RotationAlignment<S> best = rotation_.align(camera, thumbnail_, guess, options_.rotation);
    const RotationAlignment<S> still = rotation_.align(camera, thumbnail_, SO3<S>(), options_.rotation);
    if (still.valid && (!best.valid || still.cost < best.cost)) best = still;
    return best;
  }

  /// Follows all features from the last good frame and returns the rigid motion that most of them agree on.
  SE3<S> track(const View<Sensors>& view, const SE3<S>& T_predicted) {
    features_.for_each([&](auto& map) { map.track(view, backend_.window(), T_good_, T_predicted); });
    SE3<S> T = T_predicted;
    features_.for_each([&](auto& map) { map.reject_outliers(view, backend_.window(), options_.ransac, T); });
    return T;
  }

  /// Motion-only estimate, again without the outliers that it found, then with every landmark aligned with its anchor.
  /// False when it is not determined.
  bool find_motion(const View<Sensors>& view, const PosePrior<S>* prior, SE3<S>& T, Mat<S, 6, 6>& covariance) {
    if (!refine_motion(view, prior, T, covariance) || !refine_motion(view, prior, T, covariance)) return false;
    features_.for_each([&](auto& map) { map.align(view, backend_.window(), T); });
    return refine_motion(view, prior, T, covariance);
  }

  /// Takes what the frame says about the readout time; its features move along.
  void estimate_readout(const View<Sensors>& view, const SE3<S>& T_world_body, S dt) {
    if (readout_.known()) return;
    DenseNormalEquations<S, 7> system;
    const BodyView<S> body(T_world_body, view.T_body_cam);
    for_each_motion([&](auto&, auto& terms) { terms.accumulate(rig_, body, system); });
    const S before = readout().value_s;
    readout_.update(system, dt);
    features_.for_each([&](auto& map) { map.change_readout(readout().value_s - before); });
  }

  bool needs_keyframe() const {
    const KeyframeOptions& options = options_.keyframe;
    if (tracked_count() < options.min_tracked_ratio * tracked_at_keyframe_) return true;
    return mean_motion_px(keyframe_slot_) > options.max_motion_px;
  }

  /// Mean motion of the landmarks since the frame in `slot` [px]; 0 when none is seen in both.
  double mean_motion_px(int slot) const {
    double motion_px = 0;
    int count = 0;
    features_.for_each([&](const auto& map) { map.add_motion_since(slot, motion_px, count); });
    return count > 0 ? motion_px / count : 0;
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

  Health health_of_tracking() const {
    const bool few = tracked_count() < 2 * options_.motion.min_inliers;
    return {few ? HealthState::degraded : HealthState::tracking, few ? HealthReason::few_features : HealthReason::none};
  }

  /// The view's current image is the one that the next is compared with.
  void keep_image(const View<Sensors>& view, const SE3<S>& T_world_body) {
    last_ = &view.current == &pyramids_[0] ? 0 : 1;
    T_good_ = T_world_body;
  }

  Sensors rig_;
  Options options_;
  std::array<RigPyramid<Sensors>, 2> pyramids_;
  int last_ = 0;  ///< pyramid of the last frame that was tracked
  Maps features_;
  Backend backend_;
  ReadoutFilter<S> readout_;
  SE3<S> T_good_;  ///< pose of the last frame that was tracked
  int keyframe_slot_ = 0;
  int tracked_at_keyframe_ = 0;
  Estimate<S> estimate_;
  FrameTiming timing_;

 private:
  static constexpr std::size_t thumbnail_pixels = decltype(Sensors::vision)::max_pixels >>
                                                  (2 * RigPyramid<Sensors>::levels);

  /// Iteratively reweighted Gauss-Newton on the pose alone; gates outliers at the end.
  bool refine_motion(const View<Sensors>& view, const PosePrior<S>* prior, SE3<S>& T, Mat<S, 6, 6>& covariance) {
    const MotionOptions& options = options_.motion;
    for_each_motion([&](auto& map, auto& terms) { terms.collect(view, map, backend_.window()); });
    DenseNormalEquations<S, 6> system;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      const BodyView<S> body(T, view.T_body_cam);
      system.reset();
      for_each_motion([&](auto&, auto& terms) { terms.accumulate(rig_, body, system); });
      if (prior) {
        const Vec<S, 6> weight = prior->sigma.cwiseInverse();
        const Mat<S, 6, 6> J = weight.asDiagonal() * minus_jacobian(T, prior->T_world_body);
        system.add(J, Vec<S, 6>(weight.cwiseProduct(minus(T, prior->T_world_body))), S(1));
      }
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

  template <class Map>
  using MotionTermsOf = typename Map::MotionTerms;
  void for_each_motion(auto&& visit) {
    features_.for_each(
        [&](auto& map) { visit(map, std::get<MotionTermsOf<std::remove_cvref_t<decltype(map)>>>(motion_terms_)); });
  }

  Thumbnail<thumbnail_pixels> thumbnail_;
  RotationAligner<typename Sensors::Camera, thumbnail_pixels> rotation_;
  typename Maps::template TupleOf<MotionTermsOf> motion_terms_;
};

}  // namespace plumbline
