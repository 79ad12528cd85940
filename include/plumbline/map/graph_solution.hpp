#pragma once
/// Solution of the pose graph of a map in slices, and the correction of the map by it.            docs/math/map.md 1
///
/// While it goes on the window moves keyframes, and new ones come: the solution is applied with the pose that the
/// newest of its keyframes had in its world when it began.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/map_correction.hpp"
#include "plumbline/map/pose_graph_solver.hpp"

namespace plumbline {

template <class Places>
class GraphSolution {
 public:
  using S = typename Places::S;

  void begin(Places& places) {
    places.update();
    solver_.begin(places.graph());
    T_world_newest_ = places.keyframe(places.size() - 1).T_world_body;
    world_newest_ = places.world();
  }
  /// One slice, of `budget` units (pose_graph_solver.hpp); true when it is done.
  bool iterate(int budget) { return solver_.iterate(budget); }
  /// The poses become those of the solution. False, and nothing changed, where a pose is not finite or another world
  /// has begun since.
  bool apply(Places& places, MapCorrection<Places>& correction) const {
    const int n = solver_.nodes();
    for (int k = 0; k < n; ++k) {
      if (!solver_.pose(k).is_finite()) return false;
    }
    if (world_newest_ != places.world()) return false;
    places.correct(
        n, [this](int k) { return solver_.pose(k); }, T_world_newest_);
    correction.set(places.keyframe(n - 1).id, cast_to<S>(solver_.newest_covariance()), solver_.covariance_valid());
    return true;
  }

 private:
  PoseGraphSolver<typename Places::Graph> solver_;
  SE3<S> T_world_newest_;
  std::uint32_t world_newest_ = 0;
};

}  // namespace plumbline
