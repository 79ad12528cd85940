#include "imu_noise_check.hpp"

#include <algorithm>
#include <cmath>

#include "format.hpp"
#include "plumbline/imu/full_scale.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

/// What differs between the two sensors.
struct SensorWords {
  const char* name;
  const char* unit;          // of a sample
  const char* density_unit;  // of white noise
  const char* walk_unit;
  double most_vibration;  // rms
};
constexpr SensorWords gyro_words{"gyroscope", "rad/s", "rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", 0.5};
constexpr SensorWords accel_words{"accelerometer", "m/s^2", "m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)", 5};

/// A stated density that is less than half, or more than five times, of all that are possible with 95 %. Too small a
/// value makes an estimator sure of what is wrong; files often state more than the sensor has, for vibration.
void check_density(const SensorWords& words, const char* what, const char* unit, const DensityEstimate& found,
                   double stated, double rest_s, std::vector<Diagnosis>& out) {
  constexpr double most_below = 2, most_above = 5;
  const bool is_small = stated * most_below<found.low, is_large = stated> most_above * found.high;
  if (!is_small && !is_large) return;
  const double times = is_small ? found.value / stated : stated / found.high;
  out.push_back(
      {DiagnosisLevel::warning, "IMU noise",
       format("the calibration states %.2g %s as %s of the %s, %.1f times %s than %.0f s at rest show: %s%.2g", stated,
              unit, what, words.name, times, is_small ? "less" : "more", rest_s, is_small ? "" : "at most ",
              is_small ? found.value : found.high) +
           (is_small ? " is to be stated" : "; is it the noise of one sample, or of another sensor?")});
}

std::string text_of_density(const SensorWords& words, const DensityEstimate& found) {
  if (found.low > 0)
    return format("%s %.3g %s (%.3g to %.3g)", words.name, found.value, words.density_unit, found.low, found.high);
  return format("%s at most %.3g %s", words.name, found.high, words.density_unit);
}

void add_vibration(const SensorWords& words, const std::optional<Vibration>& vibration, std::vector<Diagnosis>& out) {
  if (!vibration) return;
  std::string text = format("the %s has %.2g %s rms above %.0f Hz in motion", words.name, vibration->rms, words.unit,
                            lowest_vibration_hz);
  if (vibration->peak_hz > 0) text += format(", most at %.0f Hz", vibration->peak_hz);
  const bool is_strong = vibration->rms > words.most_vibration;
  if (is_strong)
    text += format(", expected below %g: mount the IMU on dampers, or away from the motors", words.most_vibration);
  out.push_back({is_strong ? DiagnosisLevel::warning : DiagnosisLevel::ok, "vibration", text});
}

/// The full scale that the samples themselves show, or the stated one.
double full_scale_of(const std::vector<pl::ImuSample>& samples, ImuSensor sensor, double least, double stated) {
  pl::FullScaleFinder finder({.min_full_scale = least});
  for (const pl::ImuSample& sample : samples) finder.add(sample.*sensor);
  return std::min(stated, finder.found());
}

void check_full_scale(const SensorWords& words, const std::vector<pl::ImuSample>& samples, ImuSensor sensor,
                      double full_scale, std::vector<Diagnosis>& out) {
  constexpr double saturated = 0.995;
  const auto n = std::count_if(samples.begin(), samples.end(), [&](const pl::ImuSample& sample) {
    return (sample.*sensor).cwiseAbs().maxCoeff() >= saturated * full_scale;
  });
  if (n == 0) return;
  out.push_back({DiagnosisLevel::warning, "saturation",
                 format("%ld of %zu samples of the %s are saturated at %.4g %s: choose a larger range of the sensor",
                        long(n), samples.size(), words.name, full_scale, words.unit)});
}

}  // namespace

ImuNoiseFigures measure_imu_noise(const io::Recording& recording, const std::vector<TrackedFrame>& frames) {
  const std::vector<pl::ImuSample>& samples = recording.imu();
  const std::vector<SampleRange> rest = find_rest(samples, frames), motion = complement_of(rest, samples.size());
  ImuNoiseFigures out;
  for (const SampleRange& range : rest)
    out.rest_s += pl::seconds_between(samples[range.begin].t_ns, samples[range.end - 1].t_ns);
  const auto measure = [&](ImuSensor sensor, std::optional<NoiseEstimate>& noise, std::optional<Vibration>& vibration) {
    noise = estimate_noise(samples, sensor, rest);
    vibration = measure_vibration(samples, sensor, motion);
    const std::optional<Vibration> at_rest = measure_vibration(samples, sensor, rest);
    if (!noise || !at_rest || at_rest->peak_hz == 0) return;
    noise->density.low = noise->walk.low = 0;
    out.rest_vibration_hz = at_rest->peak_hz;
  };
  measure(&pl::ImuSample::gyro, out.gyro, out.gyro_vibration);
  if (recording.files().held_accel.rate_hz == 0) measure(&pl::ImuSample::accel, out.accel, out.accel_vibration);
  return out;
}

std::vector<Diagnosis> check_imu_noise(const io::Recording& recording, const ImuNoiseFigures& figures) {
  std::vector<Diagnosis> out;
  const std::optional<pl::ImuNoise>& stated = recording.calibration().imu;
  if (stated && figures.gyro) {
    check_density(gyro_words, "noise density", gyro_words.density_unit, figures.gyro->density, stated->gyro_density,
                  figures.rest_s, out);
    check_density(gyro_words, "random walk", gyro_words.walk_unit, figures.gyro->walk, stated->gyro_walk,
                  figures.rest_s, out);
  }
  if (stated && figures.accel) {
    check_density(accel_words, "noise density", accel_words.density_unit, figures.accel->density, stated->accel_density,
                  figures.rest_s, out);
    check_density(accel_words, "random walk", accel_words.walk_unit, figures.accel->walk, stated->accel_walk,
                  figures.rest_s, out);
  }
  std::string text;
  if (figures.gyro) text += text_of_density(gyro_words, figures.gyro->density);
  if (figures.accel) text += (text.empty() ? "" : ", ") + text_of_density(accel_words, figures.accel->density);
  if (text.empty())
    out.push_back({DiagnosisLevel::note, "IMU noise",
                   "noise densities cannot be told: no part of 2 s at rest; leave the sensor alone for a minute"});
  else
    out.push_back({out.empty() ? DiagnosisLevel::ok : DiagnosisLevel::note, "IMU noise",
                   format("by %.1f s at rest: ", figures.rest_s) + text +
                       (figures.rest_vibration_hz > 0
                            ? format(", as something vibrates with %.0f Hz even then", figures.rest_vibration_hz)
                            : "") +
                       (stated ? format("; stated %.3g, %.3g", stated->gyro_density, stated->accel_density) : "")});
  add_vibration(gyro_words, figures.gyro_vibration, out);
  add_vibration(accel_words, figures.accel_vibration, out);
  return out;
}

std::vector<Diagnosis> check_saturation(const io::Recording& recording) {
  constexpr double least_gyro = 1, least_accel = 5;
  const std::vector<pl::ImuSample>& samples = recording.imu();
  const pl::ImuBufferOptions& limits = recording.calibration().imu_limits;
  std::vector<Diagnosis> out;
  check_full_scale(gyro_words, samples, &pl::ImuSample::gyro,
                   full_scale_of(samples, &pl::ImuSample::gyro, least_gyro, limits.gyro_full_scale), out);
  check_full_scale(accel_words, samples, &pl::ImuSample::accel,
                   full_scale_of(samples, &pl::ImuSample::accel, least_accel, limits.accel_full_scale), out);
  return out;
}
