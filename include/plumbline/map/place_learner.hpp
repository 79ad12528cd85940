#pragma once
/// Features of a keyframe for the map: descriptors of tracked landmarks and of further corners, their bearings at the
/// middle of the frame and, where known, their ranges.                                         docs/math/map.md 1

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/map/keyframe_map_options.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/point_recall.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/orb_features.hpp"

namespace plumbline {

template <SensorRig Sensors, std::size_t MaxFeatures>
class PlaceLearner {
 public:
  using S = typename Sensors::Scalar;
  using Keyframe = PlaceKeyframe<S, MaxFeatures>;

  PlaceLearner(const Sensors& rig, const KeyframeMapOptions& options)
      : rig_(rig), options_(options), focal_px_(float(effective_focal_length(rig.vision.camera))) {}

  /// The features of a frame that becomes a keyframe: first its tracked points,
  template <class Adopted>
  void learn_tracked(const Adopted& keyframe, Keyframe& learned) {
    tracked_.clear();
    seen_at_.clear();
    orb_.clear();
    pixels_.clear();
    keyframe.for_each_observation([&](const auto& landmark, const auto& seen) {
      if constexpr (is_point<decltype(landmark)>) {
        if (pixels_.full()) return;
        Tracked tracked{.uv = seen.uv, .landmark = landmark.id};
        if (landmark.located) set_range(landmark, norm(keyframe.in_camera(landmark)), tracked);
        tracked_.push_back(tracked);
        pixels_.push_back(seen.pixel);
      }
    });
    describe_points(keyframe.image, std::span<const Vec<float, 2>>(pixels_.data(), pixels_.size()), orb_);
    for (const OrbFeature& orb : orb_) add(keyframe.depth, keyframe.shutter, orb, tracked_[orb.point], learned);
  }
  /// then points of the map that were found again: visit(feature, point) of each, which may be one that is tracked,
  template <class Adopted, class Visit>
  void learn_recalled(const Adopted& keyframe, std::span<const RecalledPoint> recalled, Keyframe& learned,
                      Visit&& visit) {
    const std::size_t tracked = learned.features.size();
    for (const RecalledPoint& again : recalled) {
      const auto ray = rig_.vision.camera.unproject(cast_to<S>(again.pixel));
      if (!ray.valid) continue;
      const Vec<float, 3> bearing = cast_to<float>(ray.bearing);
      const float near = float(options_.same_corner_px) / focal_px_;
      std::size_t n = 0;
      while (n < tracked && !(squared_norm(Vec<float, 3>(learned.features[n].bearing - bearing)) < near * near)) ++n;
      if (n == tracked) {
        const OrbDescription d = OrbDescriber::describe(keyframe.image.level(0), again.pixel);
        if (!d.valid || orb_.full()) continue;
        orb_.push_back({again.pixel, d.angle_rad, 0, OrbFeature::no_point, d.descriptor});
        n = learned.features.size();
        if (!add(keyframe.depth, keyframe.shutter, orb_.back(), {.uv = again.pixel}, learned)) continue;
        learned.features[n].sigma_rad = again.sigma_px / focal_px_;
      }
      visit(n, again.point);
    }
  }
  /// and further corners.
  template <class Adopted>
  void learn_corners(const Adopted& keyframe, Keyframe& learned) {
    const std::size_t before = orb_.size();
    add_corner_features(keyframe.image, options_.features, orb_);
    for (std::size_t n = before; n < orb_.size(); ++n)
      add(keyframe.depth, keyframe.shutter, orb_[n], {.uv = orb_[n].uv}, learned);
  }
  /// Corners alone, of a frame that is no keyframe.
  void learn_frame(const auto& view, Keyframe& learned) {
    seen_at_.clear();
    orb_.clear();
    add_corner_features(view.current, options_.features, orb_);
    for (const OrbFeature& orb : orb_) add(view.depth, view.shutter, orb, {.uv = orb.uv}, learned);
  }
  /// The final ranges of the landmarks anchored in a keyframe that retires.
  static void retire(const auto& retired, Keyframe& keyframe) {
    retired.for_each_landmark([&](const auto& landmark, const auto&) {
      if constexpr (is_point<decltype(landmark)>) {
        for (PlaceFeature& feature : keyframe.features) {
          if (feature.landmark == landmark.id) set_range(landmark, S(1) / landmark.geometry.inverse_range, feature);
        }
      }
    });
  }

  /// Of the n-th feature that was learned last, in the image.
  const Vec<float, 2>& pixel(std::size_t n) const { return seen_at_[n]; }

 private:
  struct Tracked {
    Vec<float, 2> uv;  ///< corrected [px]
    std::uint32_t landmark = PlaceFeature::no_landmark;
    float range = 0, sigma_range = 0;
  };
  template <class Landmark>
  static constexpr bool is_point = requires(const std::remove_cvref_t<Landmark>& l) {
    l.geometry.sigma_inverse_range;
    l.current.pixel;
  };

  bool add(const ImageView<const std::uint16_t>& depth, const auto& shutter, const OrbFeature& orb,
           const Tracked& tracked, Keyframe& learned) {
    PlaceFeature feature{orb.descriptor};
    feature.sigma_rad = float(orb.point != OrbFeature::no_point ? options_.tracked_sigma_px
                                                                : options_.corner_sigma_px * double(1 << orb.level)) /
                        focal_px_;
    feature.range = tracked.range;
    feature.sigma_range = tracked.sigma_range;
    feature.landmark = tracked.landmark;
    if constexpr (Sensors::has_depth) {
      if (!feature.is_located()) measure_range(depth, orb.uv, feature);
    }
    const bool is_tracked = orb.point != OrbFeature::no_point;
    const Vec<S, 2> uv =
        is_tracked ? cast_to<S>(tracked.uv)
                   : shutter.still(cast_to<S>(orb.uv), feature.is_located() ? S(1) / S(feature.range) : S(0)).uv;
    const auto ray = rig_.vision.camera.unproject(uv);
    if (!ray.valid || learned.features.full()) return false;
    feature.bearing = cast_to<float>(ray.bearing);
    learned.features.push_back(feature);
    seen_at_.push_back(orb.uv);
    return true;
  }
  static void set_range(const auto& landmark, S range, auto& feature) {
    const S sigma = landmark.geometry.sigma_inverse_range * range * range;
    if (!(range > S(0)) || !std::isfinite(sigma)) return;
    feature.range = float(range);
    feature.sigma_range = float(sigma > S(1e-3) * range ? sigma : S(1e-3) * range);
  }
  void measure_range(const ImageView<const std::uint16_t>& depth, const Vec<float, 2>& uv, PlaceFeature& feature) {
    const auto measured = rig_.vision.depth.at(depth, uv);
    if (!measured.valid) return;
    const auto ray = rig_.vision.camera.unproject(cast_to<S>(uv));
    if (!ray.valid) return;
    feature.range = float(S(1) / (measured.value * ray.bearing.z()));
    feature.sigma_range = feature.range * float(measured.sigma / measured.value);
  }

  Sensors rig_;
  KeyframeMapOptions options_;
  float focal_px_;
  static constexpr std::size_t max_tracked = MaxFeatures * 3 / 4;  ///< room for corners on all levels
  FixedVector<Tracked, max_tracked> tracked_;
  FixedVector<Vec<float, 2>, max_tracked> pixels_;
  FixedVector<OrbFeature, MaxFeatures> orb_;
  FixedVector<Vec<float, 2>, MaxFeatures> seen_at_;
};

}  // namespace plumbline
