#pragma once
/// Opens whatever is a recording: a folder, or a bag where the program is built with them.

#include <filesystem>
#include <string>

#include "plumbline/io/recording.hpp"

/// Names of the topics of a bag; empty: the only one of its kind, "none": without.
struct TopicOptions {
  std::string image, depth, imu, camera_info;
};

/// Throws io::ReadError.
plumbline::io::Recording open_recording(const std::filesystem::path& path,
                                        const plumbline::io::Recording::Options& options = {},
                                        const TopicOptions& topics = {});
