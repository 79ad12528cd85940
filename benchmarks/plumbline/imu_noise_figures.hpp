#pragma once
/// What the samples of an IMU say of its noise.

#include <optional>
#include <vector>

#include "imu_noise.hpp"
#include "plumbline/io/recording.hpp"
#include "vibration.hpp"

/// Nothing of a sensor whose samples are interpolated.
struct ImuNoiseFigures {
  double rest_s = 0;             ///< time at rest
  double rest_vibration_hz = 0;  ///< something vibrates at rest: noise is bounded from above only
  std::optional<NoiseEstimate> gyro, accel;
  std::optional<Vibration> gyro_vibration, accel_vibration;  ///< in motion
};

/// Of a recording with IMU samples.
ImuNoiseFigures measure_imu_noise(const plumbline::io::Recording& recording, const std::vector<TrackedFrame>& frames);
