#pragma once
/// What the commands that read recordings are told of them beside their folders, and what they say of them.

#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "format.hpp"
#include "largest_image.hpp"
#include "mask.hpp"
#include "open_recording.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/recording.hpp"

struct RecordingOptions {
  std::optional<std::filesystem::path> calibration;      ///< instead of the recording's own
  std::optional<std::filesystem::path> imu_calibration;  ///< noise of the IMU, instead of the calibration's
  double depth_scale = 0;                                ///< raw units per meter; 0: that of the calibration
  std::optional<double> time_offset_s;        ///< IMU time = image time + offset, instead of the calibration's
  std::optional<std::filesystem::path> mask;  ///< gray image, zero where the images do not show the scene
  double image_scale = 0;                     ///< of the images; 0: such that an estimator has room for them

  TopicOptions topics;  ///< of a bag

  plumbline::io::Recording open(const std::filesystem::path& directory, double start_s = 0,
                                double duration_s = std::numeric_limits<double>::infinity()) const {
    plumbline::io::Recording recording = open_recording(directory,
                                                        {.calibration = calibration,
                                                         .start_s = start_s,
                                                         .duration_s = duration_s,
                                                         .imu_calibration = imu_calibration,
                                                         .depth_scale = depth_scale,
                                                         .time_offset_s = time_offset_s,
                                                         .mask = mask,
                                                         .image_scale = image_scale,
                                                         .max_pixels = largest_image_px},
                                                        topics);
    (void)read_mask(recording.calibration());  // what is wrong with it is said before the work begins
    return recording;
  }
  /// The options as they are written.
  std::vector<std::string> words() const {
    std::vector<std::string> out;
    if (calibration) out.insert(out.end(), {"--calibration", calibration->filename().string()});
    if (imu_calibration) out.insert(out.end(), {"--imu-calibration", imu_calibration->filename().string()});
    if (depth_scale > 0) out.insert(out.end(), {"--depth-scale", format("%g", depth_scale)});
    if (time_offset_s) out.insert(out.end(), {"--time-offset", format("%g", *time_offset_s)});
    if (mask) out.insert(out.end(), {"--mask", mask->filename().string()});
    if (image_scale > 0) out.insert(out.end(), {"--scale", format("%g", image_scale)});
    for (const auto& [option, topic] : {std::pair{"--image-topic", &topics.image},
                                        {"--depth-topic", &topics.depth},
                                        {"--imu-topic", &topics.imu},
                                        {"--camera-info-topic", &topics.camera_info}})
      if (!topic->empty()) out.insert(out.end(), {option, *topic});
    return out;
  }
};

/// One line on stderr.
inline void print_note(const std::string& text) {
  std::fprintf(stderr, "plumbline: note: %s\n", plumbline::io::printable(text).c_str());
}
inline void print_notes(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) print_note(text);
}
