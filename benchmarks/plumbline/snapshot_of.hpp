#pragma once
/// Takes a MapSnapshot of a keyframe map, as it is between two frames.

#include <cstddef>
#include <vector>

#include "map_snapshot.hpp"
#include "plumbline/map/place_keyframe.hpp"

/// Every n-th feature is looked at, n a power of two, so that few points come and go while the map grows.
constexpr std::size_t stride_for(std::size_t features, std::size_t most) {
  std::size_t stride = 1;
  while (features > stride * most) stride *= 2;
  return stride;
}

/// Of a keyframe map. Keyframes of the present world are left out while it has no place in a map that was taken in;
/// `most_points`: at most so many points.
template <class Map>
MapSnapshot snapshot_of(const Map& map, std::size_t most_points) {
  using S = typename Map::S;
  const auto& places = map.places();
  const auto& graph = places.graph();
  MapSnapshot out;
  out.counts = map.counts();
  std::vector<int> place(static_cast<std::size_t>(places.size()), -1);  // in the snapshot
  std::size_t features = 0;
  for (int k = 0; k < places.size(); ++k) {
    const auto& keyframe = places.keyframe(k);
    if (!map.is_in_map() && keyframe.world == places.world()) continue;
    place[static_cast<std::size_t>(k)] = static_cast<int>(out.keyframes.size());
    const plumbline::Sim3<S> S_map_body(graph.pose(k));
    const plumbline::Sim3<S> S_map_world = S_map_body * plumbline::Sim3<S>(keyframe.T_world_body).inverse();
    out.keyframes.push_back({keyframe.t_ns, keyframe.world, k < map.loaded(), S_map_body.template cast<double>(),
                             S_map_world.template cast<double>()});
    features += keyframe.features.size();
  }
  const std::size_t stride = stride_for(features, most_points);
  for (int k = 0; k < places.size(); ++k) {
    if (place[static_cast<std::size_t>(k)] < 0) continue;
    const auto& keyframe = places.keyframe(k);
    const plumbline::Sim3<S> S_map_body(graph.pose(k));
    for (std::size_t n = 0; n < keyframe.features.size() && out.points.size() < most_points; n += stride) {
      const plumbline::PlaceFeature& feature = keyframe.features[n];
      if (!feature.is_located()) continue;
      const plumbline::Vec<S, 3> p_cam = plumbline::cast_to<S>(feature.bearing) * S(feature.range);
      out.points.push_back(plumbline::cast_to<float>(plumbline::Vec<S, 3>(S_map_body * (keyframe.T_body_cam * p_cam))));
    }
  }
  for (int l = 0; l < graph.loops(); ++l) {
    const int i = place[static_cast<std::size_t>(graph.loop(l).i)],
              j = place[static_cast<std::size_t>(graph.loop(l).j)];
    if (i >= 0 && j >= 0) out.loops.emplace_back(i, j);
  }
  return out;
}
