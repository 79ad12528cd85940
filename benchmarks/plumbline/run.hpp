#pragma once
/// `plumbline run`: one configuration on one recording.

#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "debug_report.hpp"

struct RunOptions {
  std::string config;
  std::filesystem::path dataset, trajectory;
  std::optional<std::filesystem::path> timing, landmarks, calibration;
  DebugOptions debug;      ///< without a directory: nothing
  bool all_poses = false;  ///< lost ones and those of a rough scale, too
  double start_s = 0;
  double duration_s = std::numeric_limits<double>::infinity();
};

/// Prints a summary to stdout; returns the exit status 0. Throws std::runtime_error that says what is wrong in one
/// line.
int run_configuration(const RunOptions& options);
