#pragma once
/// What an IMU measures above the frequencies of motion: spectrum, level and strongest frequency.

#include <cstddef>
#include <optional>
#include <vector>

#include "imu_noise.hpp"
#include "plumbline/imu/sample.hpp"

/// Mean power spectral density of the three axes, as a density like that of white noise: sqrt(one-sided PSD/2).
struct Spectrum {
  std::vector<double> hz, density;
};

struct Vibration {
  double rms = 0;      ///< of the vector, from `lowest_hz` to half the rate, noise included
  double peak_hz = 0;  ///< strongest frequency there; 0: none is five times the median
  Spectrum spectrum;
};

inline constexpr double lowest_vibration_hz = 10;  ///< hands, walking and vehicles move below

/// Over windows of 256 samples (Hann, half overlapping) inside of the parts. Nothing where there is none of them
/// without a gap, or where the rate is too low.
std::optional<Vibration> measure_vibration(const std::vector<plumbline::ImuSample>& samples, ImuSensor sensor,
                                           const std::vector<SampleRange>& parts);

/// What is not in `parts`, which are in order, of so many samples.
std::vector<SampleRange> complement_of(const std::vector<SampleRange>& parts, std::size_t samples);
