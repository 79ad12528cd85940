#pragma once
/// `plumbline doctor`: checks a recording with its calibration, by all of its images and samples.
///                                                                                     docs/guide/your_recording.md

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/io/recording.hpp"
#include "recording_options.hpp"

enum class DiagnosisLevel : std::uint8_t { ok, note, warning, error };

struct Diagnosis {
  DiagnosisLevel level;
  std::string check;  ///< what was looked at, one or two words
  std::string text;   ///< what was found, and what to do
};

/// The checks of `run`, then those that follow the images: what does not move in them, and the accelerometer, the
/// gyroscope and depth against their motion.
std::vector<Diagnosis> diagnose(const plumbline::io::Recording& recording);

struct DoctorOptions {
  std::filesystem::path dataset;
  RecordingOptions inputs;
  std::optional<std::filesystem::path> json;  ///< all diagnoses to write
};

/// Prints a line for each; returns the exit status: 1 where there is an error, else 0. Throws std::runtime_error.
int run_doctor(const DoctorOptions& options);
