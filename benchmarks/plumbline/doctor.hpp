#pragma once
/// `plumbline doctor`: checks a recording with its calibration, by all of its images and samples.
///                                                                                     docs/guide/your_recording.md

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "corner_tracks.hpp"
#include "imu_noise_figures.hpp"
#include "plumbline/io/recording.hpp"
#include "recording_options.hpp"

enum class DiagnosisLevel : std::uint8_t { ok, note, warning, error };

struct Diagnosis {
  DiagnosisLevel level;
  std::string check;  ///< what was looked at, one or two words
  std::string text;   ///< what was found, and what to do
};

/// OK, NOTE, WARN or ERROR.
const char* name_of(DiagnosisLevel level);

struct Examination {
  std::vector<Diagnosis> diagnoses;
  std::vector<TrackedFrame> frames;      ///< corners of the images, empty where they are not followed
  std::optional<ImuNoiseFigures> noise;  ///< of sound IMU samples
};

/// The checks of `run`, then those that follow the images: what does not move in them, and the accelerometer, the
/// gyroscope and depth against their motion; the noise of the IMU, its vibration and saturation.
Examination examine(const plumbline::io::Recording& recording);

struct DoctorOptions {
  std::filesystem::path dataset;
  RecordingOptions inputs;
  std::optional<std::filesystem::path> json;    ///< all diagnoses to write, docs/doctor.schema.json
  std::optional<std::filesystem::path> report;  ///< page to write: diagnoses, and what they come from over time
};

/// Prints a line for each; returns the exit status: 1 where there is an error, else 0. Throws std::runtime_error.
int run_doctor(const DoctorOptions& options);
