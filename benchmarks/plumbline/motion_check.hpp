#pragma once
/// The checks of `plumbline doctor` that follow corners through the images.

#include <vector>

#include "corner_tracks.hpp"
#include "doctor.hpp"
#include "plumbline/io/recording.hpp"

/// Without an IMU, or where its samples are not sound, only those of the images; what cannot be told is said.
/// `frames` are those of track_corners.
std::vector<Diagnosis> check_motion(const plumbline::io::Recording& recording, const std::vector<TrackedFrame>& frames,
                                    bool with_imu);
