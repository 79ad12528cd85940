#pragma once
/// What `plumbline run` and `plumbline live` do with their map.

#include <filesystem>
#include <string>

#include "runner.hpp"

/// Takes a saved map in. Throws io::ReadError.
void load_map(const std::filesystem::path& file, Runner& runner);

/// What the map has done, one line.
std::string summary_of(const MapSummary& map);

/// What to say where no place of the loaded map was recognized.
std::string not_found_in(const std::filesystem::path& map);
