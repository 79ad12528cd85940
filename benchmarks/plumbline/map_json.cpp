#include "map_json.hpp"

#include "compare_json.hpp"
#include "covisibility.hpp"

namespace io = plumbline::io;
namespace pl = plumbline;
using nlohmann::json;

json json_of_counts(const MapSummary& map) {
  const pl::KeyframeMapCounts& n = map.counts;
  return {{"keyframes", map.keyframes},
          {"evicted", n.evicted},
          {"queries", n.queries},
          {"verified", n.verified},
          {"rejected_by_gate", n.rejected_by_gate},
          {"rejected_by_tilt", n.rejected_by_tilt},
          {"rejected_as_ambiguous", n.rejected_as_ambiguous},
          {"loops", n.loops},
          {"corrections", n.corrections},
          {"relocalizations", n.relocalizations},
          {"frames_asked", n.frames_asked},
          {"frames_found", n.frames_found}};
}

json json_of_points(const io::MapContents& map, std::size_t most, const pl::Sim3<double>& S_out_map) {
  std::size_t all = 0, i = 0;
  for (const auto& entry : map.keyframes)
    entry.for_each_point([&](const pl::PlaceFeature&, const pl::Vec<double, 3>&, double) { ++all; });
  json out = json::array();
  for (const auto& entry : map.keyframes) {
    entry.for_each_point([&](const pl::PlaceFeature&, const pl::Vec<double, 3>& p_map, double) {
      if (i++ % (all / most + 1) != 0) return;
      const pl::Vec<double, 3> p = S_out_map * p_map;
      out.push_back(rounded(std::vector<double>{p.x(), p.y(), p.z()}, 3));
    });
  }
  return out;
}

json json_of_map(const io::MapContents& map) {
  constexpr std::size_t most_points = 6000;
  json keyframes{{"x", json::array()}, {"y", json::array()}, {"z", json::array()}, {"world", json::array()}};
  for (const auto& entry : map.keyframes) {
    const pl::Vec<double, 3>& p = entry.keyframe.S_map_body.t();
    keyframes["x"].push_back(rounded(p.x(), 4));
    keyframes["y"].push_back(rounded(p.y(), 4));
    keyframes["z"].push_back(rounded(p.z(), 4));
    keyframes["world"].push_back(entry.keyframe.world);
  }
  json loops = json::array(), covisible = json::array();
  for (const pl::ArchivedLoop& loop : map.loops) loops.push_back({loop.i, loop.j});
  for (const Covisibility& pair : covisible_keyframes(map)) covisible.push_back({pair.i, pair.j});
  return {{"keyframes", keyframes},
          {"loops", loops},
          {"covisible", covisible},
          {"points", json_of_points(map, most_points)}};
}
