#pragma once
/// `plumbline run`: one configuration on one recording.

#include <filesystem>
#include <limits>
#include <string>

#include "debug_report.hpp"
#include "recording_options.hpp"
#include "run_files.hpp"

struct RunOptions {
  std::string config;  ///< empty: the one that fits the recording
  std::filesystem::path dataset;
  RunPaths files;
  RecordingOptions inputs;
  DebugOptions debug;      ///< without a directory: nothing
  bool all_poses = false;  ///< lost ones and those of uncertain scale, too
  bool with_map = false;   ///< poses are those in the map
  std::optional<std::filesystem::path> loaded_map;
  bool localize_only = false;  ///< the loaded map is not changed
  bool is_unchecked = false;   ///< run although the recording looks wrong
  double start_s = 0;
  double duration_s = std::numeric_limits<double>::infinity();
};

/// Prints a summary to stdout; returns the exit status 0. Throws std::runtime_error with a message of one
/// line.
int run_configuration(const RunOptions& options);
