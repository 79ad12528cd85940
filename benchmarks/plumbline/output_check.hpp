#pragma once
/// Before anything is written: no output takes the place of another one, or of what is read.

#include <filesystem>
#include <vector>

struct NamedOutput {
  const char* option;  ///< that names it on the command line
  std::filesystem::path file;
};

/// Throws std::runtime_error that names both. Devices and pipes may be given more than once.
void check_outputs(const std::vector<NamedOutput>& outputs, const std::vector<std::filesystem::path>& inputs);
