#pragma once
/// `plumbline faults`: runs of a configuration on a recording whose images or IMU samples fail for some time.

#include <filesystem>
#include <string>
#include <vector>

#include "recording_options.hpp"
#include "results.hpp"

struct FaultOptions {
  std::vector<std::string> configs;
  std::vector<std::filesystem::path> datasets;
  RecordingOptions inputs;         ///< of all recordings
  std::vector<std::string> kinds;  ///< of fault_names(); empty: all
  std::vector<double> durations_s{0.1, 0.2, 0.3, 0.5, 1, 3};
  int times = 3;          ///< each fault at so many times of the recording
  bool with_map = false;  ///< poses are those in the map
  ResultOptions results;
};

std::vector<std::string> fault_names();

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int run_faults(const FaultOptions& options);
