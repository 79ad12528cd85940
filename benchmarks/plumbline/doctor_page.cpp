#include "doctor_page.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <utility>

#include "format.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

/// Columns over time.
struct SeriesRows {
  std::vector<std::string> names;  ///< of the columns, the first is `t`
  std::vector<std::vector<double>> rows;
};

/// Two rows for each part: with the smallest and with the largest value of each column. NaN stays where there is
/// nothing else.
SeriesRows envelope(const SeriesRows& all, std::size_t most) {
  if (all.rows.size() <= most) return all;
  SeriesRows out{all.names, {}};
  const std::size_t parts = most / 2;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t begin = part * all.rows.size() / parts, end = (part + 1) * all.rows.size() / parts;
    std::vector<double> low = all.rows[begin], high = low;
    high[0] = all.rows[begin + (end - begin) / 2][0];
    for (std::size_t i = begin + 1; i < end; ++i)
      for (std::size_t k = 1; k < low.size(); ++k) {
        low[k] = std::fmin(low[k], all.rows[i][k]);
        high[k] = std::fmax(high[k], all.rows[i][k]);
      }
    out.rows.push_back(std::move(low));
    out.rows.push_back(std::move(high));
  }
  return out;
}

double six_digits(double value) {
  return std::strtod(format("%.6g", value).c_str(), nullptr);  // NaN becomes null when it is written
}

nlohmann::json json_of(const SeriesRows& all) {
  constexpr std::size_t most = 4000;
  const SeriesRows shown = envelope(all, most);
  nlohmann::json out;
  for (std::size_t k = 0; k < shown.names.size(); ++k) {
    nlohmann::json& column = out[shown.names[k]] = nlohmann::json::array();
    for (const std::vector<double>& row : shown.rows)
      column.push_back(k == 0 ? std::round(1e6 * row[0]) / 1e6 : six_digits(row[k]));
  }
  return out;
}

/// From the stamp before to that of the row.
nlohmann::json intervals_of(const std::vector<pl::TimeNs>& times, pl::TimeNs first) {
  SeriesRows out{{"t", "ms"}, {}};
  for (std::size_t i = 1; i < times.size(); ++i)
    out.rows.push_back({pl::seconds_between(first, times[i]), 1e3 * pl::seconds_between(times[i - 1], times[i])});
  return json_of(out);
}

nlohmann::json samples_of(const std::vector<pl::ImuSample>& samples, pl::Vec<double, 3> pl::ImuSample::*sensor,
                          pl::TimeNs first) {
  SeriesRows out{{"t", "x", "y", "z"}, {}};
  for (const pl::ImuSample& sample : samples) {
    const pl::Vec<double, 3>& value = sample.*sensor;
    out.rows.push_back({pl::seconds_between(first, sample.t_ns), value.x(), value.y(), value.z()});
  }
  return json_of(out);
}

nlohmann::json looks_of(const std::vector<TrackedFrame>& frames, pl::TimeNs first) {
  SeriesRows out{{"t", "brightness", "contrast", "corners"}, {}};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TrackedFrame& frame = frames[i];
    const double followed = frame.follows ? double(pairs_of(frames[i - 1], frame).size()) : std::nan("");
    out.rows.push_back({pl::seconds_between(first, frame.t_ns), frame.brightness, frame.contrast, followed});
  }
  return json_of(out);
}

nlohmann::json json_of(const DensityEstimate& found) {
  return {{"value", six_digits(found.value)}, {"low", six_digits(found.low)}, {"high", six_digits(found.high)}};
}

nlohmann::json json_of(const std::optional<NoiseEstimate>& noise, const std::optional<Vibration>& vibration) {
  nlohmann::json out{
      {"density", nullptr}, {"random_walk", nullptr}, {"vibration_rms", nullptr}, {"vibration_peak_hz", nullptr}};
  if (noise) {
    out["density"] = json_of(noise->density);
    out["random_walk"] = json_of(noise->walk);
  }
  if (vibration) {
    out["vibration_rms"] = six_digits(vibration->rms);
    if (vibration->peak_hz > 0) out["vibration_peak_hz"] = six_digits(vibration->peak_hz);
  }
  return out;
}

nlohmann::json series_of(const std::optional<NoiseEstimate>& noise, const std::optional<Vibration>& vibration) {
  nlohmann::json out{{"allan", nullptr}, {"spectrum", nullptr}};
  if (noise)
    for (const AllanPoint& point : noise->allan) {
      out["allan"]["tau_s"].push_back(six_digits(point.tau_s));
      out["allan"]["deviation"].push_back(six_digits(point.deviation));
    }
  if (vibration)
    for (std::size_t i = 0; i < vibration->spectrum.hz.size(); ++i) {
      out["spectrum"]["hz"].push_back(six_digits(vibration->spectrum.hz[i]));
      out["spectrum"]["density"].push_back(six_digits(vibration->spectrum.density[i]));
    }
  return out;
}

}  // namespace

nlohmann::json doctor_noise(const ImuNoiseFigures& figures) {
  return {{"rest_s", six_digits(figures.rest_s)},
          {"gyroscope", json_of(figures.gyro, figures.gyro_vibration)},
          {"accelerometer", json_of(figures.accel, figures.accel_vibration)}};
}

nlohmann::json doctor_noise_series(const ImuNoiseFigures& figures) {
  return {{"gyroscope", series_of(figures.gyro, figures.gyro_vibration)},
          {"accelerometer", series_of(figures.accel, figures.accel_vibration)}};
}

nlohmann::json doctor_series(const io::Recording& recording, const std::vector<TrackedFrame>& frames) {
  const pl::TimeNs first = recording.frames().front().t_ns;
  const std::vector<pl::ImuSample>& imu = recording.imu();
  nlohmann::json out{{"images", nullptr}, {"imu", nullptr}, {"looks", nullptr}};
  if (recording.frame_count() > 1)
    out["images"] = {{"intervals", intervals_of(io::times_of(recording.frames()), first)}};
  if (imu.size() > 1)
    out["imu"] = {{"intervals", intervals_of(io::times_of(imu), first)},
                  {"gyroscope", samples_of(imu, &pl::ImuSample::gyro, first)},
                  {"accelerometer", samples_of(imu, &pl::ImuSample::accel, first)}};
  if (!frames.empty()) out["looks"] = looks_of(frames, first);
  return out;
}
