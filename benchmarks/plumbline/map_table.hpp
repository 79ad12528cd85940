#pragma once
/// Results of kind `map`: runs without and with a map, as docs/results/measure_map.py writes them.

#include <ostream>

#include <nlohmann/json.hpp>

/// A place is found by a pose within 3 sigma and so near the truth.
inline constexpr double found_m = 0.05;

/// Markdown: a table for each recording, a row for each configuration without and with a map.
void print_map_laps(std::ostream& out, const nlohmann::json& map);
void print_map_lost(std::ostream& out, const nlohmann::json& map);
void print_map_recordings(std::ostream& out, const nlohmann::json& map);

/// The three one after the other, those that have rows.
void print_map(std::ostream& out, const nlohmann::json& map);
