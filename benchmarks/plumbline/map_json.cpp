#include "map_json.hpp"

#include <vector>

#include "compare_json.hpp"
#include "covisibility.hpp"

namespace io = plumbline::io;
namespace pl = plumbline;
using nlohmann::json;

namespace {

json json_of_counts(int keyframes, const pl::KeyframeMapCounts& n) {
  return {{"keyframes", keyframes},
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

}  // namespace

json json_of_counts(const MapSummary& map) { return json_of_counts(map.keyframes, map.counts); }

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

json json_of_snapshot(const MapSnapshot& map) {
  json t = json::array(), x = t, y = t, z = t, world = t, loops = t, points = t, lines = t, times = t, corrections = t;
  for (const MapSnapshot::Keyframe& keyframe : map.keyframes) {
    const double t_s = 1e-9 * static_cast<double>(keyframe.t_ns);
    const pl::Vec<double, 3>& p = keyframe.S_map_body.t();
    t.push_back(t_s);
    x.push_back(rounded(p.x(), 4));
    y.push_back(rounded(p.y(), 4));
    z.push_back(rounded(p.z(), 4));
    world.push_back(keyframe.world);
    if (keyframe.is_loaded) continue;
    const pl::Sim3<double>& S = keyframe.S_map_world;
    const auto& q = S.rotation().quaternion().coeffs();
    times.push_back(t_s);
    corrections.push_back(
        rounded(std::vector<double>{S.scale(), q[0], q[1], q[2], q[3], S.t().x(), S.t().y(), S.t().z()}, 8));
  }
  for (const auto& [i, j] : map.loops) loops.push_back({i, j});
  for (const auto& p : map.points) points.push_back(rounded(std::vector<double>{p.x(), p.y(), p.z()}, 3));
  for (const auto& ends : map.lines) lines.push_back(rounded(std::vector<double>(ends.begin(), ends.end()), 3));
  return {{"counts", json_of_counts(static_cast<int>(map.keyframes.size()), map.counts)},
          {"keyframes", {{"t", t}, {"x", x}, {"y", y}, {"z", z}, {"world", world}}},
          {"corrections", {{"t", times}, {"S_map_world", corrections}}},
          {"loops", loops},
          {"points", points},
          {"lines", lines}};
}
