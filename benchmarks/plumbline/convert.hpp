#pragma once
/// `plumbline convert`: a bag as a folder of files.                                             docs/guide/bags.md

#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "open_recording.hpp"

struct ConvertOptions {
  std::filesystem::path bag, out;
  std::string layout;  ///< euroc or tum; empty: tum with depth, else euroc
  TopicOptions topics;
  std::optional<std::filesystem::path> calibration, imu_calibration;
  double start_s = 0;
  double duration_s = std::numeric_limits<double>::infinity();
};

/// Prints what was written; returns the exit status. Throws std::runtime_error.
int run_convert(const ConvertOptions& options);
