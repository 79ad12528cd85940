#pragma once
/// The part of the map that a camera at a supposed pose may see: the located features of the keyframes whose views
/// overlap most with its view, each landmark once, as features of the first of these keyframes.   docs/math/map.md 6

#include <algorithm>
#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/view_overlap.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

struct LocalMapOptions {
  int keyframes = 4;  ///< at most
  ViewOverlapOptions overlap;
  double min_overlap = 0.2;  ///< of their views with that of the camera
  double same_rad = 0.01;    ///< between two features that are the same point, and look the same
  int same_bits = 50;        ///< as in matches near their predictions, place_pose.hpp
};

template <class Places, std::size_t N>
class LocalMap {
 public:
  using S = typename Places::S;

  PlaceKeyframe<S, N> keyframe;  ///< features alone
  SE3<S> T_map_local;            ///< its camera, in the unit of the map

  static Sim3<S> camera_in_map(const Places& places, int k) {
    return Places::Poses::to_sim3(places.graph().pose(k)) * Sim3<S>(places.keyframe(k).T_body_cam);
  }

  /// Of a camera at T_map_cam, which sees what `frame` does, by keyframes with accept(keyframe). visit(k) is told of
  /// all whose views overlap with its view.
  void collect(const Places& places, const SE3<S>& T_map_cam, const auto& frame, const LocalMapOptions& options,
               S max_relative_sigma, const auto& accept, auto&& visit) {
    keyframe.features.clear();
    neighbors_.clear();
    const Sim3<S> S_cam_map = Sim3<S>(T_map_cam).inverse();
    const SeenRectangle seen(frame);
    for (int k = 0; k < places.size(); ++k) {
      if (!accept(places.keyframe(k))) continue;
      const S overlap = view_overlap(places.keyframe(k), S_cam_map * camera_in_map(places, k), seen, options.overlap);
      if (!(overlap > S(options.min_overlap))) continue;
      neighbors_.push_back({k, overlap});
      visit(k);
    }
    if (neighbors_.empty()) return;
    std::sort(neighbors_.begin(), neighbors_.end(), [](const Neighbor& a, const Neighbor& b) {
      return a.overlap > b.overlap || (a.overlap == b.overlap && a.k > b.k);
    });
    if (neighbors_.size() > std::size_t(options.keyframes)) neighbors_.resize(std::size_t(options.keyframes));
    const Sim3<S> S_map_first = camera_in_map(places, neighbors_[0].k);
    T_map_local = SE3<S>(S_map_first.rotation(), S_map_first.t());
    const Sim3<S> S_local_map = Sim3<S>(T_map_local).inverse();
    for (const Neighbor& neighbor : neighbors_)
      add(places.keyframe(neighbor.k), S_local_map * camera_in_map(places, neighbor.k), options, max_relative_sigma);
  }

 private:
  struct Neighbor {
    int k;
    S overlap;
  };

  void add(const typename Places::Keyframe& of, const Sim3<S>& S_local_of, const LocalMapOptions& options,
           S max_relative_sigma) {
    const float same2 = float(options.same_rad * options.same_rad);
    const std::size_t before = keyframe.features.size();
    for (const PlaceFeature& feature : of.features) {
      if (!feature.is_located() || !(S(feature.sigma_range) < max_relative_sigma * S(feature.range))) continue;
      const Vec<S, 3> p = S_local_of * Vec<S, 3>(S(feature.range) * cast_to<S>(feature.bearing));
      const S range = norm(p), unit = S_local_of.scale();
      if (!(range > S(0))) continue;
      PlaceFeature seen = feature;
      seen.bearing = cast_to<float>(Vec<S, 3>(p / range));
      seen.range = float(range);
      seen.sigma_rad *= float(unit * S(feature.range) / range);
      seen.sigma_range *= float(unit);
      const auto is_same = [&](const PlaceFeature& other) {
        if (seen.landmark != PlaceFeature::no_landmark && other.landmark == seen.landmark) return true;
        return squared_norm(Vec<float, 3>(other.bearing - seen.bearing)) < same2 &&
               hamming_distance(other.descriptor, seen.descriptor) <= options.same_bits;
      };
      if (std::any_of(keyframe.features.begin(), keyframe.features.begin() + std::ptrdiff_t(before), is_same)) continue;
      if (!keyframe.features.push_back(seen)) return;
    }
  }

  FixedVector<Neighbor, std::size_t(Places::max_keyframes)> neighbors_;
};

}  // namespace plumbline
