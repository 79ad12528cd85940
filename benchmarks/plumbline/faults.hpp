#pragma once
/// `plumbline faults`: what a configuration makes of a recording whose images or readings fail for a while.

#include <filesystem>
#include <string>
#include <vector>

struct FaultOptions {
  std::vector<std::string> configs;
  std::vector<std::filesystem::path> datasets;
  std::vector<std::string> kinds;  ///< of fault_names(); empty: all
  std::vector<double> durations_s{0.1, 0.2, 0.3, 0.5, 1, 3};
  int times = 3;  ///< each fault at so many times of the recording
};

std::vector<std::string> fault_names();

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int run_faults(const FaultOptions& options);
