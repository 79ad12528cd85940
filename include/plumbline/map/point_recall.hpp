#pragma once
/// Points of the map found again in the image of a new keyframe.                                 docs/math/map.md 5
///
/// The retired keyframes whose views overlap most with the new one tell which points are to be expected where. The
/// patch of each is aligned there, under the warp between both views (feature_alignment.hpp); MSAC over P3P keeps those
/// that agree on one pose (pose_ransac.hpp).

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/map_points.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/view_overlap.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/feature_alignment.hpp"

namespace plumbline {

struct PointRecallOptions {
  AlignmentOptions alignment{.coarse_start = true};
  ViewOverlapOptions overlap;
  double min_overlap = 0.2;  ///< of a keyframe whose points are expected
  int keyframes = 6;         ///< at most
  int border_px = 16;
  double sigma_px = 0.5;  ///< of an aligned patch on its level
  PoseRansacOptions ransac{.max_iterations = 100, .confidence = 0.999, .min_inliers = 10};
  double min_inlier_ratio = 0.5;
};

struct RecalledPoint {
  std::uint32_t point;
  Vec<float, 2> pixel;
  float sigma_px;
};

template <SensorRig Sensors, class Places, std::size_t MaxRecalled>
class PointRecall {
 public:
  using S = typename Sensors::Scalar;
  using Keyframe = typename Places::Keyframe;

  PointRecall(const Sensors& rig, const PointRecallOptions& options) : rig_(rig), options_(options) {}

  /// Points that the image of keyframe k shows beside those that its features see already.
  template <class Points>
  std::span<const RecalledPoint> recall(const Places& places, Points& points, int k, const RigPyramid<Sensors>& image) {
    recalled_.clear();
    found_.clear();
    const Keyframe& current = places.keyframe(k);
    const Sim3<S> S_cam_map = camera_in_map(places, k).inverse();
    choose(places, k, S_cam_map);
    for (const Candidate& candidate : candidates_) {
      const Keyframe& keyframe = places.keyframe(candidate.k);
      for (const PlaceFeature& feature : keyframe.features) {
        if (found_.full()) break;
        if (feature.point != PlaceFeature::no_point && points.ask(feature.point, current.id) &&
            !is_seen(current, feature.point))
          align(places, points, feature.point, S_cam_map, image);
      }
    }
    const auto agreed = ransac_pose(found_, SE3<S>(), options_.ransac);
    if (!agreed.valid || !(double(agreed.inliers) >= options_.min_inlier_ratio * double(found_.size()))) return {};
    std::size_t kept = 0;
    for (std::size_t n = 0; n < recalled_.size(); ++n) {
      if (agreed.inlier[n]) recalled_[kept++] = recalled_[n];
    }
    return {recalled_.data(), kept};
  }

 private:
  struct Candidate {
    int k;
    S overlap;
  };

  static Sim3<S> camera_in_map(const Places& places, int k) {
    return Places::Poses::to_sim3(places.graph().pose(k)) * Sim3<S>(places.keyframe(k).T_body_cam);
  }
  void choose(const Places& places, int k, const Sim3<S>& S_cam_map) {
    candidates_.clear();
    const SeenRectangle seen(places.keyframe(k));
    for (int i = 0; i < k; ++i) {
      if (!places.keyframe(i).is_retired) continue;
      const S overlap = view_overlap(places.keyframe(i), S_cam_map * camera_in_map(places, i), seen, options_.overlap);
      if (overlap > S(options_.min_overlap)) candidates_.push_back({i, overlap});
    }
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.overlap > b.overlap || (a.overlap == b.overlap && a.k > b.k);
    });
    if (candidates_.size() > std::size_t(options_.keyframes)) candidates_.resize(std::size_t(options_.keyframes));
  }
  static bool is_seen(const Keyframe& current, std::uint32_t point) {
    return std::any_of(current.features.begin(), current.features.end(),
                       [&](const PlaceFeature& feature) { return feature.point == point; });
  }
  void align(const Places& places, const auto& points, std::uint32_t number, const Sim3<S>& S_cam_map,
             const RigPyramid<Sensors>& image) {
    const auto& point = points[number];
    if (point.slot == Places::none) return;
    const Keyframe& source = places.in_slot(point.slot);
    const PlaceFeature& feature = source.features[point.feature];
    if (!source.is_retired || !feature.is_located()) return;
    int k = 0;
    while (places.slot(k) != point.slot) ++k;
    // In the unit of the camera of now.
    const Sim3<S> S_cam_source = S_cam_map * camera_in_map(places, k);
    const SE3<S> T_cam_source(S_cam_source.rotation(), S_cam_source.t());
    const Vec<S, 3> bearing = cast_to<S>(feature.bearing);
    const S range_source = S_cam_source.scale() * S(feature.range);
    const Vec<S, 3> p = T_cam_source * Vec<S, 3>(range_source * bearing);
    const auto& camera = rig_.vision.camera;
    const auto predicted = camera.project(p);
    if (!predicted.valid) return;
    const Vec<float, 2> uv = cast_to<float>(predicted.uv);
    const auto& level = image.level(0);
    const float border = float(options_.border_px);
    if (!(uv.x() >= border && uv.y() >= border && uv.x() <= float(level.width - 1) - border &&
          uv.y() <= float(level.height - 1) - border))
      return;
    const AffineWarp warp = affine_warp(camera, camera, bearing, range_source, T_cam_source);
    const Alignment aligned = align_patch<8>(point.patch, warp.A_cur_ref, image, uv, options_.alignment);
    if (!aligned.valid || image.mask().excludes(aligned.uv)) return;
    const auto ray = camera.unproject(cast_to<S>(aligned.uv));
    if (!ray.valid) return;
    const float sigma_px = float(options_.sigma_px) * float(1 << aligned.level);
    const S sigma = S(sigma_px) / effective_focal_length(camera), range = norm(p);
    // (2): the range moves the observation along that direction
    const Vec<S, 3> n = p / range, direction = T_cam_source.rotation() * bearing;
    const Vec<S, 3> across = direction - dot(n, direction) * n;
    const S of_range = S_cam_source.scale() * S(feature.sigma_range) / range;
    found_.push_back({ray.bearing, p, std::sqrt(sigma * sigma + squared_norm(across) * of_range * of_range)});
    recalled_.push_back({number, aligned.uv, sigma_px});
  }

  Sensors rig_;
  PointRecallOptions options_;
  FixedVector<Candidate, std::size_t(Places::max_keyframes)> candidates_;
  FixedVector<PoseCorrespondence<S>, MaxRecalled> found_;
  FixedVector<RecalledPoint, MaxRecalled> recalled_;
};

struct NoRecall {
  NoRecall(auto&&...) {}
};

}  // namespace plumbline
