#pragma once
/// What `plumbline doctor` writes beside its diagnoses: figures as JSON, and what its page draws.

#include <vector>

#include <nlohmann/json.hpp>

#include "corner_tracks.hpp"
#include "imu_noise_figures.hpp"
#include "plumbline/io/recording.hpp"

/// `images` and `imu`: intervals between time stamps, and the samples; `looks`: brightness, contrast and followed
/// corners of the images. Null where there are none. Times are seconds since the first frame. Of more than 4000 rows
/// the smallest and the largest value of each part are kept.
nlohmann::json doctor_series(const plumbline::io::Recording& recording, const std::vector<TrackedFrame>& frames);

/// Densities, random walks and vibration; `imu_noise` of docs/doctor.schema.json.
nlohmann::json doctor_noise(const ImuNoiseFigures& figures);

/// For each sensor its Allan deviation at rest and its spectrum in motion; null where there is none.
nlohmann::json doctor_noise_series(const ImuNoiseFigures& figures);
