#pragma once
/// `plumbline list --memory`: the size of each configuration's estimator as firmware has it.

#include <cstddef>
#include <ostream>
#include <span>

#include <nlohmann/json.hpp>

#include "results.hpp"

/// `float`, a pinhole camera with radial and tangential distortion, images of 752 x 480.
struct FirmwareSize {
  const char* name;   ///< of the configuration
  std::size_t bytes;  ///< of the estimator: all that it ever uses
};

/// Of the configurations that were compiled in; from memory_sizes.cpp.in.
std::span<const FirmwareSize> firmware_sizes();

/// Prints a table; returns the exit status 0. Throws std::runtime_error.
int list_memory(const ResultOptions& options);

/// Markdown: a row for each set of sensors and features, a column for each backend.
void print_memory(std::ostream& out, const nlohmann::json& configurations);
