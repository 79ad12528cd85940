#pragma once
/// What a calibration says of the sensors of a configuration, where there is no recording.

#include <filesystem>

#include "plumbline/io/calibration_data.hpp"
#include "runner.hpp"

/// Throws std::runtime_error where the calibration lacks what the configuration needs. `file` is what errors call it.
void require_calibrated(const Configuration& configuration, const plumbline::io::Calibration& calibration,
                        const std::filesystem::path& file);

/// The time of a frame for the estimator: IMU time, where there is an IMU.
plumbline::TimeNs frame_time(const Needs& needs, const plumbline::io::Calibration& calibration,
                             plumbline::TimeNs stamp_ns);
