#pragma once
/// `plumbline map`: what is in a saved map, and its export.

#include <filesystem>
#include <optional>

struct SavedMapOptions {
  std::filesystem::path file;
  std::optional<std::filesystem::path> ply, colmap;  ///< points; folder of a COLMAP model as text
  std::optional<std::filesystem::path> report;       ///< page
};

/// Prints to stdout; returns the exit status 0. Throws std::runtime_error.
int print_saved_map(const SavedMapOptions& options);
