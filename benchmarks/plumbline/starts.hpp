#pragma once
/// `plumbline starts`: how soon and how well a configuration starts, begun at many times of a recording.

#include <filesystem>
#include <string>
#include <vector>

struct StartOptions {
  std::vector<std::string> configs;
  std::vector<std::filesystem::path> datasets;
  double every_s = 1;
  double duration_s = 12;  ///< of each run
};

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int run_starts(const StartOptions& options);
