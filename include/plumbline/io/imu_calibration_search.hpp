#pragma once
/// Files with the noise of an IMU (Kalibr imu.yaml and its like) in the folder of a camera's calibration.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <vector>

#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io {

/// Those that state noise densities and no camera, in order of their names; what is no such file is passed over.
inline std::vector<std::filesystem::path> imu_calibrations_beside(const std::filesystem::path& camera_file) {
  namespace fs = std::filesystem;
  constexpr std::uintmax_t largest = 1 << 16;  // [bytes]
  std::vector<fs::path> out;
  const fs::path folder = camera_file.has_parent_path() ? camera_file.parent_path() : fs::path(".");
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unreadable)) {
    const fs::path extension = entry.path().extension();
    if ((extension != ".yaml" && extension != ".yml") || !entry.is_regular_file() || entry.file_size() > largest)
      continue;
    try {
      const YamlMap root(entry.path());
      const bool is_noise =
          root.has("gyroscope_noise_density") || (root.has("imu0") && root.map("imu0").has("gyroscope_noise_density"));
      if (is_noise && !root.has("cam0")) out.push_back(folder / entry.path().filename());
    } catch (const ReadError&) {
      continue;
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace plumbline::io
