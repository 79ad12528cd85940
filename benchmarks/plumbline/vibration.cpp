#include "vibration.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <opencv2/core.hpp>

#include "plumbline/core/time.hpp"
#include "statistics.hpp"

namespace pl = plumbline;

namespace {

constexpr int vibration_window = 256;  // samples

/// Power of one axis in the bins from zero to half the rate, of a window of samples.
void add_power(const std::vector<pl::ImuSample>& samples, std::size_t begin, ImuSensor sensor, int axis,
               std::vector<double>& power) {
  cv::Mat values(1, vibration_window, CV_64F), bins;
  double mean = 0;
  for (int i = 0; i < vibration_window; ++i) mean += (samples[begin + std::size_t(i)].*sensor)[axis] / vibration_window;
  for (int i = 0; i < vibration_window; ++i) {
    const double hann = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / vibration_window);
    values.at<double>(i) = hann * ((samples[begin + std::size_t(i)].*sensor)[axis] - mean);
  }
  cv::dft(values, bins, cv::DFT_COMPLEX_OUTPUT);
  for (int i = 0; i <= vibration_window / 2; ++i) {
    const auto& bin = bins.at<cv::Vec2d>(i);
    power[std::size_t(i)] += bin[0] * bin[0] + bin[1] * bin[1];
  }
}

}  // namespace

std::optional<Vibration> measure_vibration(const std::vector<pl::ImuSample>& samples, ImuSensor sensor,
                                           const std::vector<SampleRange>& parts) {
  constexpr double hann_power = 0.375, least_ratio = 5;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < samples.size(); ++i)
    intervals.push_back(pl::seconds_between(samples[i - 1].t_ns, samples[i].t_ns));
  const double T = median(intervals);
  if (!(T > 0 && 1 / T > 4 * lowest_vibration_hz)) return std::nullopt;
  std::vector<double> power(vibration_window / 2 + 1);
  double windows = 0;
  for (const SampleRange& part : parts) {
    for (std::size_t begin = part.begin; begin + vibration_window <= part.end; begin += vibration_window / 2) {
      const double duration = pl::seconds_between(samples[begin].t_ns, samples[begin + vibration_window - 1].t_ns);
      if (std::abs(duration - (vibration_window - 1) * T) > 2 * T) continue;
      for (int axis = 0; axis < 3; ++axis) add_power(samples, begin, sensor, axis, power);
      ++windows;
    }
  }
  if (windows == 0) return std::nullopt;
  Vibration out;
  std::vector<double> high;
  double squares = 0, strongest = 0;
  for (std::size_t i = 1; i < power.size(); ++i) {
    const double hz = double(i) / (vibration_window * T);
    const double two_sided = power[i] / (3 * windows) * T / (vibration_window * hann_power);  // of one axis
    out.spectrum.hz.push_back(hz);
    out.spectrum.density.push_back(std::sqrt(two_sided));
    if (hz < lowest_vibration_hz) continue;
    squares += 3 * 2 * two_sided / (vibration_window * T);
    high.push_back(two_sided);
    if (two_sided <= strongest) continue;
    strongest = two_sided;
    out.peak_hz = hz;
  }
  out.rms = std::sqrt(squares);
  if (!(strongest > least_ratio * median(high))) out.peak_hz = 0;
  return out;
}

std::vector<SampleRange> complement_of(const std::vector<SampleRange>& parts, std::size_t samples) {
  std::vector<SampleRange> out;
  std::size_t begin = 0;
  for (const SampleRange& part : parts) {
    if (begin < part.begin) out.push_back({begin, part.begin});
    begin = part.end;
  }
  if (begin < samples) out.push_back({begin, samples});
  return out;
}
