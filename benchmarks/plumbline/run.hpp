#pragma once
/// `plumbline run`: one configuration on one recording.

#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "debug_report.hpp"
#include "run_files.hpp"

struct RunOptions {
  std::string config;  ///< empty: the one that fits the recording
  std::filesystem::path dataset;
  RunPaths files;
  std::optional<std::filesystem::path> calibration;
  DebugOptions debug;         ///< without a directory: nothing
  bool all_poses = false;     ///< lost ones and those of uncertain scale, too
  bool is_unchecked = false;  ///< run although the recording looks wrong
  double start_s = 0;
  double duration_s = std::numeric_limits<double>::infinity();
};

/// Prints a summary to stdout; returns the exit status 0. Throws std::runtime_error with a message of one
/// line.
int run_configuration(const RunOptions& options);
