// Rates of images and IMU samples, and whether their time stamps overlap.
#include <algorithm>
#include <array>
#include <cmath>

#include "format.hpp"
#include "recording_check.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

/// What a rate may be [Hz]: beyond `lowest` and `highest` nothing works, below `low` it is odd.
struct Rates {
  const char* what;
  double lowest, low, highest;
  const char* usual;
};
constexpr Rates image_rates{"image rate", 0.5, 5, 1000, "10 to 60 Hz"};
constexpr Rates sample_rates{"IMU sample rate", 40, 90, 20'000, "100 to 1000 Hz"};

constexpr std::array<const char*, 4> units{"seconds", "milliseconds", "microseconds", "nanoseconds"};
int unit_of(io::Layout layout) { return layout == io::Layout::euroc ? 3 : 0; }

std::string asked_unit(int unit, io::Layout layout) {
  return format(": are the time stamps in %s instead of %s?", units[static_cast<std::size_t>(unit)],
                units[static_cast<std::size_t>(unit_of(layout))]);
}

/// Asks for the unit that time stamps are probably in when their rate, read in another one, is impossible.
std::string unit_by_rate(double rate, const Rates& rates, io::Layout layout) {
  for (int unit = 0; unit < 4; ++unit) {
    const double factor = std::pow(1e3, unit - unit_of(layout));
    if (unit != unit_of(layout) && rate * factor >= rates.low && rate * factor <= rates.highest / 5)
      return asked_unit(unit, layout);
  }
  return {};
}

/// The same where the time stamps of IMU and images have the ratio of two units.
std::string unit_by_ratio(pl::TimeNs imu, pl::TimeNs image, io::Layout layout) {
  if (imu <= 0 || image <= 0) return ": do IMU and images have the same clock, unit and time zone?";
  const double thousands = std::log(static_cast<double>(image) / static_cast<double>(imu)) / std::log(1e3);
  const int unit = unit_of(layout) - static_cast<int>(std::lround(thousands));
  const bool is_unit = std::abs(thousands - std::round(thousands)) < 1e-3 && unit >= 0 && unit < 4;
  return is_unit && unit != unit_of(layout) ? asked_unit(unit, layout)
                                            : ": do IMU and images have the same clock and time zone?";
}

/// Of the median interval; 0 of fewer than two times.
double rate_of(const std::vector<pl::TimeNs>& times) {
  std::vector<pl::TimeNs> intervals;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return 1e9 / static_cast<double>(*middle);
}

std::string name_of(const std::filesystem::path& file) { return file.string() + ": "; }

void check_rate(const std::filesystem::path& file, double rate, double stated, const Rates& rates, io::Layout layout,
                std::vector<Finding>& findings) {
  const std::string found = name_of(file) + format("the %s is %.4g Hz", rates.what, rate);
  const std::string expected = std::string(", expected ") + rates.usual;
  if (rate < rates.lowest || rate > rates.highest) {
    findings.push_back({true, found + expected + unit_by_rate(rate, rates, layout)});
  } else if (rate < rates.low) {
    findings.push_back({false, found + expected});
  } else if (stated > 0 && std::abs(std::log(rate / stated)) > std::log(1.5)) {
    findings.push_back({false, found + format(", the calibration has %g Hz: is data missing?", stated)});
  }
}

/// Samples that come close together and then not for a while: their stamps are those of arrival.
bool check_bursts(const std::filesystem::path& file, const std::vector<pl::TimeNs>& times, const char* what,
                  std::vector<Finding>& findings) {
  if (times.size() < 100) return false;
  const double mean = static_cast<double>(times.size() - 1) / pl::seconds_between(times.front(), times.back());
  const double inside = rate_of(times);
  std::size_t bursts = 1;
  for (std::size_t i = 1; i < times.size(); ++i) bursts += pl::seconds_between(times[i - 1], times[i]) > 2 / mean;
  const double each = static_cast<double>(times.size()) / static_cast<double>(bursts);
  if (!(inside > 3 * mean) || each < 3 || each > 1000) return false;
  findings.push_back(
      {true, name_of(file) + format("the %ss come in bursts of %.0f, %.3g ms apart, then not for %.3g ms: these are "
                                    "stamps of arrival; stamp them by the sensor's clock, or evenly at %.4g Hz",
                                    what, each, 1e3 / inside, 1e3 * each / mean - 1e3 * (each - 1) / inside, mean)});
  return true;
}

/// The longest time without any of them.
void check_gaps(const std::filesystem::path& file, const std::vector<pl::TimeNs>& times, const char* what,
                double longest_s, std::vector<Finding>& findings) {
  double gap_s = 0, at_s = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double s = pl::seconds_between(times[i - 1], times[i]);
    if (s <= gap_s) continue;
    gap_s = s;
    at_s = pl::seconds_between(times.front(), times[i - 1]);
  }
  if (gap_s > longest_s)
    findings.push_back({false, name_of(file) + format("no %s for %.3g s, %.1f s after the first one; expected gaps "
                                                      "below %.3g s",
                                                      what, gap_s, at_s, longest_s)});
}

void check_overlap(const io::Recording& recording, const std::vector<pl::TimeNs>& frames,
                   const std::vector<pl::TimeNs>& samples, std::vector<Finding>& findings) {
  const auto first = std::lower_bound(frames.begin(), frames.end(), samples.front());
  const auto last = std::upper_bound(first, frames.end(), samples.back());
  const double share = static_cast<double>(last - first) / static_cast<double>(frames.size());
  const std::string file = name_of(*recording.files().imu_index);
  if (share == 0) {
    const bool after = samples.front() > frames.back();
    const double apart_s = after ? pl::seconds_between(frames.back(), samples.front())
                                 : pl::seconds_between(samples.back(), frames.front());
    findings.push_back({true, file +
                                  format("the IMU samples %s %.6g s %s image", after ? "begin" : "end", apart_s,
                                         after ? "after the last" : "before the first") +
                                  unit_by_ratio(samples.back(), frames.front(), recording.layout())});
  } else if (share < 0.9) {
    findings.push_back(
        {false, file + format("IMU samples cover %.0f %% of the images, expected all of them", 100 * share)});
  }
}

}  // namespace

std::vector<Finding> check_time_offsets(const io::Recording& recording, const Needs& needs) {
  std::vector<Finding> findings;
  const io::RecordingFiles& files = recording.files();
  const std::vector<pl::TimeNs> frames = io::times_of(recording.frames());
  if (frames.size() > 1) {
    const double rate = rate_of(frames);
    check_rate(files.frame_index, rate, recording.calibration().camera.rate_hz, image_rates, files.layout, findings);
    if (findings.empty()) check_gaps(files.frame_index, frames, "image", std::max(1.0, 5 / rate), findings);
  }
  if (!needs.imu || !files.imu_index) return findings;
  const std::vector<pl::TimeNs> samples = io::times_of(recording.imu());
  if (samples.size() > 1 && !check_bursts(*files.imu_index, samples, "IMU sample", findings))
    check_rate(*files.imu_index, rate_of(samples), recording.calibration().imu->rate_hz, sample_rates, files.layout,
               findings);
  const bool is_sound = std::none_of(findings.begin(), findings.end(), [](const Finding& f) { return f.is_error; });
  if (is_sound) {
    check_gaps(*files.imu_index, samples, "IMU sample", 0.3, findings);
    check_overlap(recording, frames, samples, findings);
  }
  return findings;
}
