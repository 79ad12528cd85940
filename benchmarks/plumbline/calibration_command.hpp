#pragma once
/// `plumbline calibration`: what was understood of a calibration file, in words with units and frames, and the same
/// calibration in another format.                                                  docs/guide/your_recording.md

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/io/calibration_data.hpp"

struct CalibrationOptions {
  std::filesystem::path file;
  std::optional<std::filesystem::path> imu_calibration;  ///< noise of the IMU, instead of the calibration's
  std::string to;                                        ///< kalibr or plain: the format to write; empty: none
};

/// One line each, a heading where it does not begin with a blank.
std::vector<std::string> describe(const plumbline::io::Calibration& calibration);

/// Prints to stdout; with `to`, the calibration in that format under the description as comments. Returns the exit
/// status 0. Throws std::runtime_error.
int run_calibration(const CalibrationOptions& options);
