#pragma once
/// `plumbline compare`: configurations on recordings, from several first frames, side by side.
///                                                                                             docs/guide/compare.md

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "recording_options.hpp"

struct CompareOptions {
  std::vector<std::string> configs;             ///< names, or patterns of the shell
  std::vector<std::filesystem::path> datasets;  ///< folders of recordings with truth
  RecordingOptions inputs;                      ///< of all recordings
  std::vector<std::filesystem::path> merge;     ///< files of comparisons, instead of running any
  std::optional<std::filesystem::path> json, report, markdown;
  std::string shard = "1/1";  ///< which part of the runs, of how many
  std::size_t repeats = 1;    ///< runs of each, their first frames one frame apart
  std::size_t processes = 0;  ///< side by side; 0: as many as there are cores
  double start_s = 0;
  double duration_s = std::numeric_limits<double>::infinity();
  double limit_s = 600;   ///< of one run
  bool with_map = false;  ///< poses are those in the map
};

/// Prints a table; returns the exit status. Throws std::runtime_error.
int run_compare(const CompareOptions& options);
