#pragma once
/// Geometric verification of a recognized place: the pose of a camera in an older one, from matched features of which
/// the older keyframe knows the ranges.                                                      docs/math/map.md 2
///
/// Mutual matches (descriptor_matching.hpp) -> MSAC over P3P, or two points and the vertical -> matches anew near the
/// predicted bearings, without a test against the second nearest -> Gauss-Newton (place_refinement.hpp) -> where there
/// are patches of the older keyframe, the same with them, aligned in the image of the current one (loop_alignment.hpp).
/// The scale of the current world in the older one is the weighted mean of log(|p_i| / range of the match), where both
/// ranges are known                                                                                              (4)

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/gravity_pose_ransac.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/place_refinement.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"

namespace plumbline {

struct PlacePoseOptions {
  DescriptorMatchOptions matching{};
  DescriptorMatchOptions guided{50, 1.0f};  ///< near the predicted bearing, where few others are
  double guided_rad = 0.02;                 ///< distance from the predicted bearing
  double max_relative_sigma = 0.3;          ///< of the range of a feature that takes part
  PoseRansacOptions ransac{.max_iterations = 200, .confidence = 0.999, .min_inliers = 10};
  int min_inliers = 20;           ///< after guided matching; paper C, 6
  double min_inlier_ratio = 0.5;  ///< of the guided matches
};

/// What an IMU tells of two keyframes.
template <class S>
struct PlaceVertical {
  SO3<S> R_level_old;    ///< from the older camera to axes whose z is up
  Vec<S, 3> up_current;  ///< unit, in the current camera
};

template <class S>
struct PlacePose {
  bool valid = false;
  SE3<S> T_old_current;                        ///< between the cameras, in the unit of the older world
  Mat<S, 6, 6> covariance = zeros<S, 6, 6>();  ///< of its right increment [rad, unit of the older world]
  int matches = 0, inliers = 0;
  S noise2 = S(1);             ///< mean squared error of the inliers, of that which their sigmas tell
  S log_scale = S(0);          ///< (4), of the unit of the current world in that of the older one
  S log_scale_sigma = S(1e3);  ///< large: not known
};

/// Work space and result of the verification; one object serves all. At most N features of the older keyframe, and M of
/// the current one.
template <class S, std::size_t N, std::size_t M = N>
class PlacePoseSolver {
 public:
  using Keyframe = PlaceKeyframe<S, N>;
  using Current = PlaceKeyframe<S, M>;
  using Correspondences = FixedVector<PoseCorrespondence<S>, N>;

  /// Pose of `current` in `old`; `prior` is the pose predicted, the first hypothesis. `vertical`: where not null, the
  /// vertical that an IMU tells in both. `align(T_old_current, visit)` calls visit(feature, bearing, sigma_rad) for
  /// features of `old` that it has aligned in the image of `current`, whose pose is about that.
  const PlacePose<S>& solve(const Keyframe& old, const Current& current, const SE3<S>& prior,
                            const PlacePoseOptions& options, const PlaceVertical<S>* vertical, const auto& align) {
    out_ = {};
    take(old, current, options);
    out_.matches = int(match_descriptors(old_descriptors(), current_descriptors(), options.matching, room()));
    if (out_.matches < options.ransac.min_inliers) return out_;
    const PoseRansacResult<S, N> result = search(old, current, prior, options, vertical);
    if (!result.valid) return out_;
    SE3<S> T = result.T_cam_world.inverse();
    (void)refinement_.solve(T, S(options.ransac.chi2));
    match_guided(old, current, T, options);
    if (finish(old, current, T, options).valid) improve(align, options);
    return out_;
  }
  const PlacePose<S>& solve(const Keyframe& old, const Current& current, const SE3<S>& prior,
                            const PlacePoseOptions& options) {
    return solve(old, current, prior, options, nullptr, [](auto&&...) {});
  }
  /// The same where the i-th feature of both is the same point.
  const PlacePose<S>& solve_matched(const Keyframe& old, const Current& current, const SE3<S>& prior,
                                    const PlacePoseOptions& options) {
    out_ = {};
    old_index_.clear();
    for (std::size_t i = 0; i < old.features.size() && i < current.features.size(); ++i) {
      matches_[i] = {i, i, 0};
      old_index_.push_back(i);
    }
    out_.matches = int(old_index_.size());
    if (out_.matches < options.ransac.min_inliers) return out_;
    const PoseRansacResult<S, N> result = search(old, current, prior, options, nullptr);
    if (!result.valid) return out_;
    return finish(old, current, result.T_cam_world.inverse(), options);
  }
  /// The matches that the last valid pose agrees with: (feature of the older keyframe, of the current one).
  std::span<const DescriptorMatch> inliers() const { return {inliers_.data(), inliers_.size()}; }

 private:
  const PlacePose<S>& finish(const Keyframe& old, const Current& current, SE3<S> T, const PlacePoseOptions& options) {
    if (!refinement_.solve(T, S(options.ransac.chi2))) return out_;
    take_solution(T);
    out_.inliers = refinement_.inliers();
    find_scale(old, current, T);
    keep_inliers();
    out_.valid = out_.inliers >= options.min_inliers && out_.inliers >= options.min_inlier_ratio * out_.matches;
    return out_;
  }
  void take_solution(const SE3<S>& T) {
    out_.T_old_current = T;
    out_.covariance = refinement_.covariance();
    out_.noise2 = refinement_.noise2();
  }
  /// By the patches of the older keyframe that were aligned, and the matches of its other features.
  void improve(const auto& align, const PlacePoseOptions& options) {
    refinement_.keep_inliers();
    int aligned = 0;
    align(out_.T_old_current, [&](const PlaceFeature& old, const Vec<S, 3>& bearing, S sigma_rad) {
      aligned += refinement_.add_aligned(old, bearing, sigma_rad);
    });
    if (aligned == 0) return;
    SE3<S> T = out_.T_old_current;
    for (int pass = 0; pass < 3; ++pass) {
      refinement_.scale_aligned(T);
      if (!refinement_.solve(T, S(options.ransac.chi2))) return;
    }
    if (refinement_.inliers() >= options.min_inliers) take_solution(T);
  }
  void take(const Keyframe& old, const Current& current, const PlacePoseOptions& options) {
    old_.clear();
    current_.clear();
    old_index_.clear();
    for (std::size_t i = 0; i < old.features.size(); ++i) {
      const PlaceFeature& feature = old.features[i];
      if (!feature.is_located() || !(feature.sigma_range < options.max_relative_sigma * feature.range)) continue;
      old_.push_back(feature.descriptor);
      old_index_.push_back(i);
    }
    for (const PlaceFeature& feature : current.features) current_.push_back(feature.descriptor);
  }
  std::span<const BinaryDescriptor> old_descriptors() const { return {old_.data(), old_.size()}; }
  std::span<const BinaryDescriptor> current_descriptors() const { return {current_.data(), current_.size()}; }
  std::span<DescriptorMatch> room() { return {matches_.data(), matches_.size()}; }

  /// The pose that most matches agree with.
  PoseRansacResult<S, N> search(const Keyframe& old, const Current& current, const SE3<S>& prior,
                                const PlacePoseOptions& options, const PlaceVertical<S>* vertical) {
    fill(old, current);
    if (!vertical) return ransac_pose(correspondences_, prior.inverse(), options.ransac);
    const SE3<S> T_level_old(vertical->R_level_old, zeros<S, 3>());
    for (PoseCorrespondence<S>& c : correspondences_) c.p_world = T_level_old * c.p_world;
    auto result = ransac_gravity_pose(correspondences_, vertical->up_current, prior.inverse() * T_level_old.inverse(),
                                      options.ransac);
    result.T_cam_world = result.T_cam_world * T_level_old;
    fill(old, current);
    return result;
  }
  void fill(const Keyframe& old, const Current& current) {
    correspondences_.clear();
    refinement_.clear();
    for (int m = 0; m < out_.matches; ++m) {
      const PlaceFeature& a = old.features[old_index_[matches_[std::size_t(m)].first]];
      const PlaceFeature& b = current.features[matches_[std::size_t(m)].second];
      const Vec<S, 3> bearing = cast_to<S>(b.bearing);
      correspondences_.push_back({bearing, cast_to<S>(a.bearing) * S(a.range), S(b.sigma_rad)});
      (void)refinement_.add(a, bearing, S(b.sigma_rad));
    }
  }
  void match_guided(const Keyframe& old, const Current& current, const SE3<S>& T, const PlacePoseOptions& options) {
    const SE3<S> T_current_old = T.inverse();
    predicted_.clear();
    for (const std::size_t i : old_index_) {
      const PlaceFeature& a = old.features[i];
      predicted_.push_back(cast_to<float>(normalized(Vec<S, 3>(T_current_old * (cast_to<S>(a.bearing) * S(a.range))))));
    }
    const float limit = float(options.guided_rad * options.guided_rad);
    out_.matches = int(match_descriptors(
        old_descriptors(), current_descriptors(), options.guided, room(), [&](std::size_t i, std::size_t j) {
          return squared_norm(Vec<float, 3>(predicted_[i] - current.features[j].bearing)) < limit;
        }));
    fill(old, current);
  }

  void keep_inliers() {
    inliers_.clear();
    for (std::size_t m = 0; m < std::size_t(out_.matches); ++m) {
      if (!refinement_[m].is_inlier) continue;
      inliers_.push_back({old_index_[matches_[m].first], matches_[m].second, matches_[m].distance});
    }
  }
  void find_scale(const Keyframe& old, const Current& current, const SE3<S>& T) {
    S weights = S(0), sum = S(0);
    const SE3<S> inverse = T.inverse();
    for (int pass = 0; pass < 3; ++pass) {  // the mean, then without what is far from it
      const S mean = weights > S(0) ? sum / weights : S(0), known = weights;
      weights = sum = S(0);
      for (int m = 0; m < out_.matches; ++m) {
        const PlaceFeature& a = old.features[old_index_[matches_[std::size_t(m)].first]];
        const PlaceFeature& b = current.features[matches_[std::size_t(m)].second];
        if (!b.is_located()) continue;
        const S range = norm(Vec<S, 3>(inverse * correspondences_[std::size_t(m)].p_world));
        const S sa = S(a.sigma_range / a.range), sb = S(b.sigma_range / b.range), v = sa * sa + sb * sb + S(1e-4);
        const S x = std::log(range / S(b.range)), e2 = (x - mean) * (x - mean) / v;
        if (!std::isfinite(x)) continue;
        const S robust = known > S(0) ? S(9) / (S(9) + e2) : S(1);
        weights += robust / v;
        sum += robust * x / v;
      }
    }
    if (!(weights > S(0))) return;
    out_.log_scale = sum / weights;
    out_.log_scale_sigma = S(1) / std::sqrt(weights);
  }

  PlacePose<S> out_;
  FixedVector<BinaryDescriptor, N> old_;
  FixedVector<BinaryDescriptor, M> current_;
  FixedVector<std::size_t, N> old_index_;
  FixedVector<Vec<float, 3>, N> predicted_;
  std::array<DescriptorMatch, N> matches_;
  FixedVector<DescriptorMatch, N> inliers_;
  Correspondences correspondences_;
  PlaceRefinement<S, N> refinement_;
};

}  // namespace plumbline
