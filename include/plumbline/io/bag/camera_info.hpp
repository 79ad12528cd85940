#pragma once
/// The calibration of a camera by its CameraInfo.

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/io/bag/messages.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "plumbline/io/calibration_systems.hpp"
#include "plumbline/io/yaml_map.hpp"

namespace plumbline::io::bag {

/// By the text that `rostopic echo` would print, so that the same checks are made.
inline Calibration calibration_of(const std::filesystem::path& name, const CameraInfoMessage& info) {
  const auto list = [](const std::vector<double>& values) {
    std::string out;
    for (const double value : values) {
      char text[40];
      std::snprintf(text, sizeof text, "%s%.17g", out.empty() ? "" : ", ", value);
      out += text;
    }
    return "[" + out + "]";
  };
  const std::string model = info.distortion_model.empty() ? "\"\"" : info.distortion_model;
  return io::detail::read_camera_info(
      YamlMap(name, "width: " + std::to_string(info.width) + "\nheight: " + std::to_string(info.height) +
                        "\ndistortion_model: " + model + "\nD: " + list(info.D) + "\nK: " + list(info.K) + "\n"));
}

}  // namespace plumbline::io::bag
