#pragma once
/// Checks of a recording before the run: time stamps, rates and units of the IMU, content of the images. They use
/// every time stamp and IMU sample, and a few images.
///                                                                                     docs/guide/your_recording.md

#include <string>
#include <vector>

#include "plumbline/io/recording.hpp"
#include "runner.hpp"

struct Finding {
  bool is_error;     ///< a run cannot work; else it is odd
  std::string text;  ///< one line: file, what was found, what is expected, and what was probably meant
};

/// Of all that a configuration with these needs will use; empty where nothing is odd.
std::vector<Finding> check_recording(const plumbline::io::Recording& recording, const Needs& needs);

/// The parts of it.
std::vector<Finding> check_time_offsets(const plumbline::io::Recording& recording, const Needs& needs);
std::vector<Finding> check_imu_samples(const plumbline::io::Recording& recording);
/// How far the stated noise of gyroscope and accelerometer exceeds the scatter of their samples, vibration included: a
/// line for each that does. A filter in the sensor makes that scatter smaller, so this is no fault by itself.
std::vector<std::string> excess_of_stated_noise(const plumbline::io::Recording& recording);
std::vector<Finding> check_images(const plumbline::io::Recording& recording, const Needs& needs);
