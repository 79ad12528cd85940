#pragma once
/// `plumbline relocalizations`: a map of the first half of a recording, and runs that begin at many times of the second
/// half and look for their place in it.

#include <filesystem>
#include <string>
#include <vector>

#include "recording_options.hpp"
#include "results.hpp"

struct RelocalizationOptions {
  std::vector<std::string> configs;
  std::vector<std::filesystem::path> datasets;
  RecordingOptions inputs;  ///< of all recordings
  double every_s = 1;       ///< 0: at every frame
  double duration_s = 3;    ///< of each run
  ResultOptions results;
};

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int run_relocalizations(const RelocalizationOptions& options);
