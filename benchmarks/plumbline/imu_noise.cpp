#include "imu_noise.hpp"

#include <algorithm>
#include <cmath>

#include "statistics.hpp"

namespace pl = plumbline;

namespace {

using Samples = std::vector<pl::ImuSample>;
using ImuVector = pl::Vec<double, 3>;

double duration_of(const Samples& samples, const SampleRange& range) {
  return pl::seconds_between(samples[range.begin].t_ns, samples[range.end - 1].t_ns);
}

// --------------------------------------------------------------------------------------------------------------- rest

constexpr double window_s = 0.5, least_rest_s = 2;

/// Mean of a sensor over a window, and the scatter of its samples by second differences, of one axis.
struct SensorWindow {
  ImuVector mean = ImuVector::Zero();
  double sigma = 0;
};

SensorWindow window_of(const Samples& samples, const SampleRange& range, ImuSensor sensor) {
  SensorWindow out;
  double squares = 0;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    out.mean += samples[i].*sensor;
    if (i >= range.begin + 2)
      squares += (samples[i].*sensor - 2 * (samples[i - 1].*sensor) + samples[i - 2].*sensor).squaredNorm();
  }
  const auto n = double(range.end - range.begin);
  out.mean /= n;
  out.sigma = std::sqrt(squares / (18 * (n - 2)));
  return out;
}

/// Windows of half a second without a gap.
std::vector<SampleRange> windows_of(const Samples& samples) {
  constexpr std::size_t least = 10;
  std::vector<SampleRange> out;
  std::size_t begin = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const bool is_gap = pl::seconds_between(samples[i - 1].t_ns, samples[i].t_ns) > window_s / 4;
    if (!is_gap && pl::seconds_between(samples[begin].t_ns, samples[i].t_ns) < window_s) continue;
    if (!is_gap && i - begin >= least) out.push_back({begin, i});
    begin = i;
  }
  return out;
}

/// Whether means are the same but for four sigma, or what no motion stays below for seconds.
bool are_same(const SensorWindow& a, const SensorWindow& b, double n, double motion) {
  return (a.mean - b.mean).norm() < std::max(motion, 4 * std::hypot(a.sigma, b.sigma) * std::sqrt(3 / n));
}

/// Times from frame to frame in which corners move by half a pixel or more.
std::vector<pl::TimeNs> moving_times(const std::vector<TrackedFrame>& frames) {
  constexpr double most_px = 0.5;
  std::vector<pl::TimeNs> out;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (!frames[i].follows) continue;
    std::vector<double> motions;
    for (const CornerPair& pair : pairs_of(frames[i - 1], frames[i]))
      motions.push_back((pair.second->uv - pair.first->uv).norm());
    if (median(motions) > most_px) out.push_back(frames[i].t_ns);
  }
  return out;
}

}  // namespace

std::vector<SampleRange> find_rest(const Samples& samples, const std::vector<TrackedFrame>& frames) {
  constexpr double most_bias = 0.2, gyro_motion = 0.01, accel_motion = 0.05, usual_noise = 2;
  const std::vector<SampleRange> windows = windows_of(samples);
  const std::vector<pl::TimeNs> moving = moving_times(frames);
  std::vector<SensorWindow> gyro, accel;
  std::vector<double> gyro_sigmas, accel_sigmas;
  for (const SampleRange& window : windows) {
    gyro.push_back(window_of(samples, window, &pl::ImuSample::gyro));
    accel.push_back(window_of(samples, window, &pl::ImuSample::accel));
    gyro_sigmas.push_back(gyro.back().sigma);
    accel_sigmas.push_back(accel.back().sigma);
  }
  const double gyro_quiet = percentile(gyro_sigmas, 0.1), accel_quiet = percentile(accel_sigmas, 0.1);
  const auto is_quiet = [&](std::size_t k) {
    if (gyro[k].mean.norm() > most_bias || gyro[k].sigma > usual_noise * gyro_quiet ||
        accel[k].sigma > usual_noise * accel_quiet)
      return false;
    const auto next = std::lower_bound(moving.begin(), moving.end(), samples[windows[k].begin].t_ns);
    return next == moving.end() || *next > samples[windows[k].end - 1].t_ns;
  };
  std::vector<SampleRange> out;
  for (std::size_t k = 0; k < windows.size();) {
    std::size_t end = k;
    const auto fits = [&](std::size_t i) {
      const auto n = double(windows[i].end - windows[i].begin);
      const auto is_like = [&](std::size_t other) {
        return are_same(gyro[other], gyro[i], n, gyro_motion) && are_same(accel[other], accel[i], n, accel_motion);
      };
      return is_quiet(i) && (i == k || (windows[i - 1].end == windows[i].begin && is_like(i - 1) && is_like(k)));
    };
    while (end < windows.size() && fits(end)) ++end;
    if (end == k) {
      ++k;
      continue;
    }
    // What comes before and after it may reach into the outer windows.
    if (end - k > 2) {
      const SampleRange range{windows[k + 1].begin, windows[end - 2].end};
      if (duration_of(samples, range) >= least_rest_s) out.push_back(range);
    }
    k = end;
  }
  return out;
}

// -------------------------------------------------------------------------------------------------------------- noise

namespace {

struct Octave {
  std::size_t m;       // samples in a mean
  double squares = 0;  // of differences, summed over axes
  double values = 0;   // so many
};

/// From one sample up to a quarter of the longest part.
std::vector<Octave> octaves_of(const Samples& samples, ImuSensor sensor, const std::vector<SampleRange>& rest) {
  std::vector<Octave> out;
  for (const SampleRange& range : rest) {
    std::vector<ImuVector> sums;  // of the first samples of it, about the first one
    sums.push_back(ImuVector::Zero());
    for (std::size_t i = range.begin; i < range.end; ++i)
      sums.push_back(sums.back() + samples[i].*sensor - samples[range.begin].*sensor);
    const std::size_t n = range.end - range.begin;
    std::size_t octave = 0;
    for (std::size_t m = 1; 4 * m <= n; m *= 2, ++octave) {
      if (octave == out.size()) out.push_back({m});
      for (std::size_t at = 0; at + 2 * m <= n; at += 2 * m) {
        const ImuVector d = (sums[at + 2 * m] - 2 * sums[at + m] + sums[at]) / double(m);
        out[octave].squares += d.squaredNorm();
        out[octave].values += 3;
      }
    }
  }
  return out;
}

/// Terms of (1) for an octave.
struct VarianceModel {
  double white, walk;    // factors of N^2 and K^2
  double found, values;  // mean of d^2/2
};

DensityEstimate density_of(double square, double sigma) {
  const auto root = [](double x) { return std::sqrt(std::max(x, 0.0)); };
  return {root(square), root(square - 2 * sigma), root(square + 2 * sigma)};
}

}  // namespace

std::optional<NoiseEstimate> estimate_noise(const Samples& samples, ImuSensor sensor,
                                            const std::vector<SampleRange>& rest) {
  constexpr double most_misfit = 2;
  constexpr double shortest_s = 0.02;  // below it a filter of the sensor shows; an estimator integrates over more
  double duration_s = 0, intervals = 0;
  for (const SampleRange& range : rest) {
    duration_s += duration_of(samples, range);
    intervals += double(range.end - range.begin - 1);
  }
  if (!(duration_s > 0)) return std::nullopt;
  const double T = duration_s / intervals;
  NoiseEstimate out;
  std::vector<VarianceModel> models;
  for (const Octave& octave : octaves_of(samples, sensor, rest)) {
    const double m = double(octave.m), variance = octave.squares / (2 * octave.values);
    out.allan.push_back({m * T, std::sqrt(variance), octave.values});
    if (m * T > shortest_s && variance > 0)
      models.push_back({1 / (m * T), T * (2 * m * m + 1) / (6 * m), variance, octave.values});
  }
  if (models.size() < 3) return std::nullopt;

  double white = models.front().found / models.front().white, walk = 0;  // N^2, K^2
  double information_white = 0, information_walk = 0, mixed = 0, determinant = 0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    double right_white = 0, right_walk = 0;
    information_white = information_walk = mixed = 0;
    for (const VarianceModel& model : models) {
      const double variance = model.white * white + model.walk * walk;
      const double weight = model.values / (2 * variance * variance);
      information_white += weight * model.white * model.white;
      information_walk += weight * model.walk * model.walk;
      mixed += weight * model.white * model.walk;
      right_white += weight * model.white * model.found;
      right_walk += weight * model.walk * model.found;
    }
    determinant = information_white * information_walk - mixed * mixed;
    white = (information_walk * right_white - mixed * right_walk) / determinant;
    walk = (information_white * right_walk - mixed * right_white) / determinant;
    if (!(walk > 0)) white = right_white / information_white;
    if (!(white > 0)) walk = right_walk / information_walk;
    walk = std::max(walk, 0.0);
    white = std::max(white, 0.0);
  }
  double chi2 = 0;
  for (const VarianceModel& model : models) {
    const double ratio = model.found / (model.white * white + model.walk * walk) - 1;
    chi2 += model.values / 2 * ratio * ratio;
  }
  const double scale = std::sqrt(std::max(1.0, chi2 / double(models.size() - 2)));
  out.density = density_of(white, scale * std::sqrt(information_walk / determinant));
  out.walk = density_of(walk, scale * std::sqrt(information_white / determinant));
  if (scale > most_misfit) out.density.low = out.walk.low = 0;
  return out;
}
