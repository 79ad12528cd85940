#pragma once
/// The table of `plumbline relocalizations`.

#include <ostream>

#include <nlohmann/json.hpp>

/// A localized pose is right when it is within these of the truth.
inline constexpr double right_position_m = 0.25, right_rotation_deg = 2;
/// A run counts when its first true pose is within these of a keyframe of the map.
inline constexpr double reach_m = 1, reach_deg = 30;

/// Figures of the runs of one configuration on one recording, in one line.
void print_relocalization_summary(std::ostream& out, const nlohmann::json& group);

/// Markdown: a table for each recording, a row for each configuration.
void print_relocalizations(std::ostream& out, const nlohmann::json& groups);
