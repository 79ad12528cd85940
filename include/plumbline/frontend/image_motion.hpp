#pragma once
/// Pose of a frame by sparse image alignment: from the patches around all landmarks in the previous image, before the
/// features are tracked.                                                                        docs/math/direct.md

#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/pose_prior.hpp"
#include "plumbline/tracking/image_alignment.hpp"

namespace plumbline {

struct ImageMotionOptions : ImageAlignmentOptions {
  /// Prior sigma of the predicted rotation when the prediction has none [rad]; tuned: docs/decisions/135 (chosen).
  double sigma_rotation = 0.05;
  /// Prior sigma of the predicted translation when the prediction has none, relative to the mean range;
  /// tuned: docs/decisions/135 (chosen).
  double sigma_translation = 0.05;
};

template <SensorRig Sensors, int MaxSamples>
class ImageMotion {
 public:
  using S = typename Sensors::Scalar;
  using Options = ImageMotionOptions;
  struct Named {
    Options image_alignment;
  };
  static const Options& options_of(const Named& all) { return all.image_alignment; }

  explicit ImageMotion(const Options& options) : options_(options) {}

  void clear() { samples_.clear(); }
  void add(const AlignmentSample<S>& sample) { samples_.push_back(sample); }

  /// Moves a predicted pose to the best alignment with the previous image. False, and the pose unchanged, when the
  /// alignment is not valid.
  bool align(const View<Sensors>& view, const PosePrior<S>& prior, SE3<S>& T_world_body) {
    const SE3<S> T_cur_prev = T_world_body.inverse() * view.T_world_previous;
    const auto increment_prior = IncrementPrior<S>::of(T_cur_prev, prior.valid ? prior.sigma : default_sigma());
    scratch_.resize(samples_.size());
    errors_.resize(samples_.size());
    ImageAligner<typename Sensors::Camera> aligner(view.camera(), view.T_body_cam, {samples_.data(), samples_.size()},
                                                   {scratch_.data(), scratch_.size()}, {errors_.data(), errors_.size()},
                                                   options_);
    const Levels previous = levels_of(view.previous), current = levels_of(view.current);
    latest_ = aligner.align(previous, current, increment_prior, T_cur_prev);
    if (latest_.valid) T_world_body = view.T_world_previous * latest_.T_cur_prev.inverse();
    return latest_.valid;
  }

  /// Result of the last call.
  const ImageAlignment<S>& latest() const { return latest_; }

 private:
  /// Sigma of [dphi, dp] without a prior [rad, m].
  Vec<S, 6> default_sigma() const {
    S inverse_range = S(0);
    for (const AlignmentSample<S>& sample : samples_) inverse_range += 1 / norm(sample.p_body);
    const S range = samples_.empty() ? S(1) : S(samples_.size()) / inverse_range;
    Vec<S, 6> sigma;
    for (int k = 0; k < 3; ++k) {
      sigma[k] = S(options_.sigma_rotation);
      sigma[3 + k] = S(options_.sigma_translation) * range;
    }
    return sigma;
  }

  static constexpr int levels = RigPyramid<Sensors>::levels;
  using Levels = std::array<ImageView<const std::uint8_t>, levels>;

  static Levels levels_of(const RigPyramid<Sensors>& pyramid) {
    Levels out;
    for (int l = 0; l < levels; ++l) out[static_cast<std::size_t>(l)] = pyramid.level(l);
    return out;
  }

  Options options_;
  FixedVector<AlignmentSample<S>, MaxSamples> samples_;
  FixedVector<AlignmentPatch, MaxSamples> scratch_;
  FixedVector<float, MaxSamples> errors_;
  ImageAlignment<S> latest_;
};

}  // namespace plumbline
