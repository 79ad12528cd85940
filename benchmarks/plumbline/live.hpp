#pragma once
/// `plumbline live`: one configuration on frames and IMU samples as they come, from standard input or a socket.
///                                                                                                  docs/guide/live.md

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

struct LiveOptions {
  std::string config;
  std::optional<std::filesystem::path> calibration, imu_calibration;  ///< instead of those of the stream
  std::optional<std::filesystem::path> mask;                          ///< gray image, zero: not the scene
  double depth_scale = 0;                                             ///< instead of the calibration's; 0: as it is
  std::string address;          ///< port or path; empty: standard input and output
  std::string format = "json";  ///< of estimates: json, binary or binary-map
  bool sender_waits = false;    ///< nothing is dropped
  std::size_t queue = 4;        ///< frames that wait, at most
  bool with_map = false;
  std::optional<std::filesystem::path> loaded_map, saved_map;
  bool localize_only = false;  ///< the loaded map is not changed
  std::optional<std::filesystem::path> trajectory;
  std::optional<int> page;  ///< port of 127.0.0.1 of a page that shows trajectory and map; 0: a free one
};

/// Prints a summary to stderr; returns the exit status 0. Throws std::runtime_error with a message of one line; what
/// came before a fault of the stream is in the trajectory.
int run_live(const LiveOptions& options);
