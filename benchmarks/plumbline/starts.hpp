#pragma once
/// `plumbline starts`: initialization of a configuration in runs that begin at many times of a recording.

#include <filesystem>
#include <string>
#include <vector>

#include "recording_options.hpp"
#include "results.hpp"

struct StartOptions {
  std::vector<std::string> configs;
  std::vector<std::filesystem::path> datasets;
  RecordingOptions inputs;  ///< of all recordings
  double every_s = 1;
  double duration_s = 12;  ///< of each run
  bool with_map = false;   ///< poses are those in the map
  ResultOptions results;
};

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int run_starts(const StartOptions& options);
