// Whether IMU samples are in the expected units and axes.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "format.hpp"
#include "plumbline/lie/so3.hpp"
#include "recording_check.hpp"
#include "statistics.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

using Samples = std::vector<pl::ImuSample>;
using ImuVector = pl::Vec<double, 3>;

constexpr double degree = std::numbers::pi / 180;

/// A stationary accelerometer measures 9.8 m/s^2 upward; in motion the median of the norm is close to it.
void check_gravity(const std::string& file, const Samples& samples, std::vector<Finding>& findings) {
  std::vector<double> lengths;
  for (const pl::ImuSample& sample : samples) lengths.push_back(sample.accel.norm());
  const double length = percentile(lengths, 0.5);
  const char* meant = length < 0.05                         ? "is the accelerometer dead?"
                      : length > 0.8 && length < 1.25       ? "is it in g instead of m/s^2?"
                      : length < 5                          ? "has gravity been subtracted?"
                      : length > 800 && length < 1250       ? "is it in thousandths of g instead of m/s^2?"
                      : length > 28 && length < 36          ? "is it in feet instead of meters?"
                      : length > 8000 && length < 1e4 * 1.2 ? "is it in mm/s^2 instead of m/s^2?"
                                                            : "is the unit m/s^2?";
  const bool is_error = !(length > 5 && length < 20);
  if (is_error || !(length > 8.3 && length < 11.8))
    findings.push_back({is_error, file + format("the median norm of the accelerometer is %.3g, expected 9.8 m/s^2: %s",
                                                length, meant)});
}

/// By how much the direction of the specific force changes within one second, in a frame rotated by the integrated
/// gyroscope times `scale`: by acceleration alone if that is right. Root mean square over the windows.
double turn_of_gravity(const Samples& samples, double scale) {
  constexpr double window_s = 1;
  constexpr std::size_t most_windows = 60;
  const double duration_s = pl::seconds_between(samples.front().t_ns, samples.back().t_ns);
  const std::size_t windows = std::min(most_windows, static_cast<std::size_t>(duration_s / (window_s / 2)));
  double squares = 0;
  int n = 0;
  for (std::size_t w = 0; w + 1 < windows; ++w) {
    const double begin_s = static_cast<double>(w) * (duration_s - window_s) / static_cast<double>(windows);
    const pl::TimeNs begin_ns = samples.front().t_ns + std::llround(begin_s * 1e9);
    auto sample = std::lower_bound(samples.begin(), samples.end(), begin_ns,
                                   [](const pl::ImuSample& s, pl::TimeNs t) { return s.t_ns < t; });
    pl::SO3<double> R_begin_now;
    ImuVector first = ImuVector::Zero(), last = ImuVector::Zero();
    for (; std::next(sample) != samples.end(); ++sample) {
      const double t = pl::seconds_between(begin_ns, sample->t_ns);
      const double dt = std::min(pl::seconds_between(sample->t_ns, std::next(sample)->t_ns), 0.05);
      if (t > window_s) break;
      if (t < 0.25 * window_s) first += R_begin_now * sample->accel;
      if (t > 0.75 * window_s) last += R_begin_now * sample->accel;
      R_begin_now = R_begin_now * pl::SO3<double>::exp(dt * scale * sample->gyro);
    }
    if (!(first.norm() > 0 && last.norm() > 0)) continue;
    const double angle = std::atan2(first.cross(last).norm(), first.dot(last));
    squares += angle * angle;
    ++n;
  }
  return n < 3 ? 0 : std::sqrt(squares / n);
}

void check_rates(const std::string& file, const Samples& samples, std::vector<Finding>& findings) {
  std::vector<double> rates, forces;
  for (const pl::ImuSample& sample : samples) {
    rates.push_back(sample.gyro.norm());
    forces.push_back(sample.accel.norm());
  }
  const double usual = percentile(rates, 0.9);
  // Strong acceleration changes the direction as well; then the norm of the specific force varies, too.
  const double force = percentile(forces, 0.5), spread = percentile(forces, 0.9) - percentile(forces, 0.1);
  const double as_read = turn_of_gravity(samples, 1), as_degrees = turn_of_gravity(samples, degree);
  const bool whirls = usual > 1 && spread < 0.3 * force && as_read > 40 * degree && as_degrees < 0.4 * as_read;
  if (usual <= 6 && !whirls) return;
  findings.push_back({usual > 12 || whirls,
                      file + format("90 %% of the gyroscope samples are up to %.3g, expected 0.01 to 5 rad/s: is it in "
                                    "degrees instead of radians per second?",
                                    usual)});
}

/// Noise of one sample: the 10th percentile over quarters of a second of sqrt(|a - 2 b + c|^2 / 18), of one axis.
/// Vibration makes it larger, a filter of the sensor smaller.
double quiet_sigma(const Samples& samples, ImuVector pl::ImuSample::*sensor) {
  std::vector<double> sigmas;
  double squares = 0;
  int n = 0;
  pl::TimeNs begin_ns = samples.front().t_ns;
  for (std::size_t i = 2; i < samples.size(); ++i) {
    const ImuVector difference = samples[i].*sensor - 2 * (samples[i - 1].*sensor) + samples[i - 2].*sensor;
    squares += difference.squaredNorm();
    ++n;
    if (pl::seconds_between(begin_ns, samples[i].t_ns) < 0.25) continue;
    sigmas.push_back(std::sqrt(squares / (18 * n)));
    squares = n = 0;
    begin_ns = samples[i].t_ns;
  }
  return sigmas.empty() ? 0 : percentile(sigmas, 0.1);
}

/// Root of the mean sample rate [sqrt(Hz)].
double root_rate(const Samples& samples) {
  const double duration_s = pl::seconds_between(samples.front().t_ns, samples.back().t_ns);
  return std::sqrt(static_cast<double>(samples.size() - 1) / duration_s);
}

/// Samples up to the last frame.
Samples samples_of(const io::Recording& recording) {
  Samples samples;
  for (const pl::ImuSample& sample : recording.imu())
    if (sample.t_ns <= recording.frames().back().t_ns) samples.push_back(sample);
  return samples;
}

/// Densities far above what the samples show are those of another program, or of one sample.
void check_stated_noise(const std::string& file, const io::Recording& recording, const Samples& samples,
                        std::vector<Finding>& findings) {
  constexpr double most = 10;
  const auto check = [&](const char* what, double density, double sigma) {
    const double stated = density * root_rate(samples);
    if (!(sigma > 0) || stated < most * sigma) return;
    findings.push_back(
        {false, file + format("the samples of the %s are %.0f times quieter than the stated noise density "
                              "%g: is that the noise of one sample (divide by the root of the rate)?",
                              what, stated / sigma, density)});
  };
  check("gyroscope", recording.calibration().imu->gyro_density, quiet_sigma(samples, &pl::ImuSample::gyro));
  if (recording.files().held_accel.rate_hz > 0) return;
  check("accelerometer", recording.calibration().imu->accel_density, quiet_sigma(samples, &pl::ImuSample::accel));
}

}  // namespace

std::vector<std::string> excess_of_stated_noise(const io::Recording& recording) {
  const Samples samples = samples_of(recording);
  if (samples.size() < 3 || !recording.calibration().imu) return {};
  std::vector<std::string> out;
  const auto report = [&](const char* what, double density, ImuVector pl::ImuSample::*sensor) {
    const double sigma = quiet_sigma(samples, sensor), stated = density * root_rate(samples);
    if (!(sigma > 0 && stated > sigma)) return;
    out.push_back(
        format("the stated noise density of the %s, %g, is %.1f times all that its samples show, vibration "
               "included: is it that of one sample, or of another program?",
               what, density, stated / sigma));
  };
  report("gyroscope", recording.calibration().imu->gyro_density, &pl::ImuSample::gyro);
  if (!(recording.files().held_accel.rate_hz > 0))
    report("accelerometer", recording.calibration().imu->accel_density, &pl::ImuSample::accel);
  return out;
}

std::vector<Finding> check_imu_samples(const io::Recording& recording) {
  const Samples samples = samples_of(recording);
  std::vector<Finding> findings;
  if (samples.size() < 2) return findings;
  const std::string file = recording.files().imu_index->string() + ": ";
  check_gravity(file, samples, findings);
  check_rates(file, samples, findings);
  if (findings.empty() && recording.calibration().imu) check_stated_noise(file, recording, samples, findings);
  return findings;
}
