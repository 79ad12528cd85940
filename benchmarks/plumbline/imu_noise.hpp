#pragma once
/// Noise densities and random walks of an IMU, from its samples at rest.
///
/// a, b: means of m samples each, b after a, of an axis at rest with white noise of density N and a bias that walks
/// with density K; T: time between samples, d = b - a. Half of the mean square is the Allan variance at tau = m T:
///   E d^2/2 = N^2/(m T) + K^2 T (2 m^2 + 1)/(6 m)                                                              (1)
/// Differences that do not overlap, for m = 1, 2, 4, ..., are those of Haar wavelets: uncorrelated for white noise. The
/// likelihood of all of them, as normal values with the variances (1), is maximized over N^2 >= 0 and K^2 >= 0 by
/// Fisher scoring. Its information gives the uncertainty, which is scaled by sqrt(chi^2/(octaves - 2)) where (1) does
/// not fit. Above two of it, what is found bounds the noise from above only.

#include <cstddef>
#include <optional>
#include <vector>

#include "corner_tracks.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/sample.hpp"

using ImuSensor = plumbline::Vec<double, 3> plumbline::ImuSample::*;

/// Samples `begin` to `end` - 1.
struct SampleRange {
  std::size_t begin, end;
};

/// Parts of two seconds and more in which means over half a second differ by little more than their noise, and the
/// corners of the images stay where they are.
std::vector<SampleRange> find_rest(const std::vector<plumbline::ImuSample>& samples,
                                   const std::vector<TrackedFrame>& frames);

struct AllanPoint {
  double tau_s, deviation;
  double values;  ///< differences of all axes that it comes from
};

/// A density with its interval of 95 %. `low` is zero where it is only known what it is not above: too little time, or
/// something else than noise.
struct DensityEstimate {
  double value = 0, low = 0, high = 0;
};

struct NoiseEstimate {
  DensityEstimate density, walk;
  std::vector<AllanPoint> allan;
};

/// Of the three axes together. Nothing where there is too little, or where all samples are the same.
std::optional<NoiseEstimate> estimate_noise(const std::vector<plumbline::ImuSample>& samples, ImuSensor sensor,
                                            const std::vector<SampleRange>& rest);
