#pragma once
/// A map as files of figures and the pages have it.

#include <cstddef>

#include <nlohmann/json.hpp>

#include "map_snapshot.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/lie/sim3.hpp"
#include "runner.hpp"

/// What a map has done in a run.
nlohmann::json json_of_counts(const MapSummary& map);

/// [x, y, z] of every n-th point, so that at most so many remain; moved by S_out_map.
nlohmann::json json_of_points(const plumbline::io::MapContents& map, std::size_t most,
                              const plumbline::Sim3<double>& S_out_map = {});

/// Positions and worlds of the keyframes, pairs of keyframes that a loop connects or that see the same, and points.
nlohmann::json json_of_map(const plumbline::io::MapContents& map);

/// The map of a run as it is now: counts, keyframes, loops, points, lines, and what corrects a pose of the run: that of
/// the latest keyframe before it, as scale, quaternion x y z w, translation.
nlohmann::json json_of_snapshot(const MapSnapshot& map);
