#pragma once
/// The poses of a run in its map, as the map corrects them at the end of the run.

#include <cstddef>
#include <vector>

#include "plumbline/io/trajectory.hpp"
#include "runner.hpp"

/// Each pose of the world with the correction of the latest keyframe before it; `corrections` in order of time.
inline plumbline::io::Trajectory final_trajectory(const plumbline::io::Trajectory& poses,
                                                  const std::vector<MapCorrection>& corrections) {
  plumbline::io::Trajectory out;
  std::size_t k = 0;
  for (const auto& pose : poses) {
    while (k + 1 < corrections.size() && corrections[k + 1].t_ns <= pose.t_ns) ++k;
    const plumbline::Sim3<double> S_map_world =
        corrections.empty() ? plumbline::Sim3<double>() : corrections[k].S_map_world;
    const plumbline::Sim3<double> S_map_body = S_map_world * plumbline::Sim3<double>(pose.T_world_body);
    out.push_back({pose.t_ns, {S_map_body.rotation(), S_map_body.t()}});
  }
  return out;
}
