#pragma once
/// plumbline.run: one configuration on one recording.

#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/io/trajectory.hpp"
#include "recording_options.hpp"

struct PythonRun {
  std::string config;
  plumbline::io::Trajectory trajectory;  ///< poses as `plumbline run --trajectory` writes them
  std::vector<plumbline::Vec<double, 3>> landmarks;
  std::string summary;
  std::vector<std::string> notes;  ///< on files and sensors, skipped images and refused frames
};

struct PythonRunOptions {
  std::string config;  ///< empty: the one that fits the recording
  bool with_map = false, all_poses = false, is_unchecked = false;
  double start_s = 0, duration_s = std::numeric_limits<double>::infinity();
  RecordingOptions inputs;
};

/// Called with Python's lock, works without it; Ctrl-C ends it. Throws std::runtime_error.
PythonRun run_recording(const std::filesystem::path& dataset, const PythonRunOptions& options);
