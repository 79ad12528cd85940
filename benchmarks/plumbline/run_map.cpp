#include "run_map.hpp"

#include <cstddef>
#include <vector>

#include "format.hpp"
#include "plumbline/io/map_file.hpp"

namespace pl = plumbline;

void load_map(const std::filesystem::path& file, Runner& runner) {
  const std::vector<std::byte> bytes = pl::io::read_map_bytes(file);
  if (const pl::MapArchiveError error = runner.load_map(bytes); error != pl::MapArchiveError::none)
    throw pl::io::ReadError(file, 0, pl::name_of(error));
}

std::string summary_of(const MapSummary& map) {
  const pl::KeyframeMapCounts& n = map.counts;
  return format(
      "map: %d keyframes (%d evicted), %d places recognized of %d queries, %d loops, %d relocalizations, "
      "%d corrections; refused: %d by the odometry, %d by gravity, "
      "%d as ambiguous; %d points found again, %d local adjustments; %d of %d single frames found",
      map.keyframes, n.evicted, n.verified, n.queries, n.loops, n.relocalizations, n.corrections, n.rejected_by_gate,
      n.rejected_by_tilt, n.rejected_as_ambiguous, n.recalled, n.adjustments, n.frames_found, n.frames_asked);
}

std::string not_found_in(const std::filesystem::path& map) {
  return map.string() + ": no place of the map was recognized, and no pose is written in it";
}
