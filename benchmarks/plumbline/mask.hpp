#pragma once
/// The mask of a calibration: a gray image whose zero pixels do not show the scene.     docs/guide/your_recording.md

#include <opencv2/core/mat.hpp>

#include "plumbline/io/calibration_data.hpp"

/// CV_8U of the size of the images; empty where the calibration names none. Throws std::runtime_error where the file is
/// no such image, or excludes nothing or everything.
cv::Mat read_mask(const plumbline::io::Calibration& calibration);
