#pragma once
/// Insertion of a loop into the pose graph of a map: where there is no room another one goes, and a world that was not
/// connected with the map before joins it.                                                      docs/math/map.md 1

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/pose_graph.hpp"

namespace plumbline {

/// Whether a loop connects that world with another one.
template <class Places>
bool is_connected(const Places& places, std::uint32_t world) {
  const auto& graph = places.graph();
  for (int l = 0; l < graph.loops(); ++l) {
    const std::uint32_t a = places.keyframe(graph.loop(l).i).world, b = places.keyframe(graph.loop(l).j).world;
    if (a != b && (a == world || b == world)) return true;
  }
  return false;
}

/// The loop whose later end is nearest to that of another one.
template <class Places>
int most_crowded_loop(const Places& places) {
  const auto& graph = places.graph();
  int best = 0, least = Places::max_keyframes;
  for (int l = 0; l < graph.loops(); ++l) {
    int nearest = Places::max_keyframes;
    for (int m = 0; m < graph.loops(); ++m) {
      if (m != l) nearest = std::min(nearest, std::abs(graph.loop(l).j - graph.loop(m).j));
    }
    if (nearest >= least) continue;
    least = nearest;
    best = l;
  }
  return best;
}

/// Inserts a loop (PlaceLoop). False where one of its keyframes was removed, or it is no edge.
template <class Places, class Loop>
bool insert_loop(Places& places, const Loop& loop, KeyframeMapCounts& counts) {
  const int i = places.find(loop.i), j = places.find(loop.j);
  if (i == Places::none || j == Places::none) return false;
  auto& graph = places.graph();
  if (graph.loops() == Places::Graph::max_loops) graph.remove_loop(most_crowded_loop(places));
  if (places.keyframe(i).world != places.keyframe(j).world && !is_connected(places, places.keyframe(j).world)) {
    places.join(j, graph.pose(i) * loop.T_i_j);  // the solution would begin far from where it ends
    ++counts.relocalizations;
  }
  if (graph.add_loop(i, j, loop.T_i_j, loop.covariance) != PoseGraphInsertion::inserted) return false;
  ++counts.loops;
  return true;
}

}  // namespace plumbline
