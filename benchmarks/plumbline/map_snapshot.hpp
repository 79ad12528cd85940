#pragma once
/// A map as it is during a run, for a page to draw: small, and copied without a look at most of the features.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"

struct MapSnapshot {
  struct Keyframe {
    plumbline::TimeNs t_ns;
    std::uint32_t world;
    bool is_loaded;  ///< of a map that was taken in
    plumbline::Sim3<double> S_map_body, S_map_world;
  };
  plumbline::KeyframeMapCounts counts;
  std::vector<Keyframe> keyframes;
  std::vector<std::pair<int, int>> loops;        ///< places in `keyframes`
  std::vector<plumbline::Vec<float, 3>> points;  ///< in the map
  std::vector<std::array<float, 6>> lines;       ///< edges of the window in the map, from start to end
};
