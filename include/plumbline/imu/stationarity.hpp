#pragma once
/// Stationarity detection by IMU samples, and the state of a stationary body.          docs/math/initialization.md
///
/// The samples of the last second are averaged in blocks of 0.1 s: vibration of rotors and motors has frequencies far
/// above 10 Hz, motion lasts longer. For a stationary body the block means do not spread:
///   spread = sqrt(mean |m_b - mean m|^2)  below a limit, for both sensors                                       (3)
/// and the means are explained by a bias and gravity. Uniform straight motion gives the same samples: the caller
/// combines the result with the images. For a stationary body
///   b_g = mean w,   g_body = -mean a,   b_a = (|mean a| - G) mean a/|mean a|  (its observable part)             (4)

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/nav_state.hpp"

namespace plumbline {

struct StationarityOptions {
  int blocks = 10;             ///< number of blocks; tuned: docs/decisions/021
  double block_s = 0.1;        ///< length of a block [s]; tuned: docs/decisions/021
  int min_block_samples = 3;   ///< smallest number of samples in a block; sensor: IMU of 30 Hz and more
  double gyro_spread = 0.012;  ///< limit of (3) for the gyroscope [rad/s]; tuned: docs/decisions/021
  double accel_spread = 0.2;   ///< limit of (3) for the accelerometer [m/s^2]; tuned: docs/decisions/021
  /// Largest plausible gyroscope bias [rad/s]; sensor: zero-rate offset of MEMS, about 10 deg/s.
  double gyro_bias = 0.2;
  double gravity_error = 0.5;  ///< largest | |mean a| - G | [m/s^2]; sensor: zero-g offset of MEMS, about 50 mg
};

/// Stationary, or the reason why not.
enum class StationarityVerdict : std::uint8_t { stationary, too_few_samples, rotating, accelerating, implausible };

/// For logs.
constexpr const char* name_of(StationarityVerdict verdict) {
  switch (verdict) {
    case StationarityVerdict::stationary: return "stationary";
    case StationarityVerdict::too_few_samples: return "too few samples";
    case StationarityVerdict::rotating: return "rotating";
    case StationarityVerdict::accelerating: return "accelerating";
    case StationarityVerdict::implausible: return "mean sample beyond any bias";
  }
  return "unknown verdict";
}

struct StationarityReport {
  StationarityVerdict verdict = StationarityVerdict::too_few_samples;
  int blocks = 0;                                  ///< blocks with enough samples
  Vec<double, 3> mean_gyro = zeros<double, 3>();   ///< [rad/s]
  Vec<double, 3> mean_accel = zeros<double, 3>();  ///< [m/s^2]
  double gyro_spread = 0, accel_spread = 0;        ///< (3) [rad/s, m/s^2]

  bool is_stationary() const { return verdict == StationarityVerdict::stationary; }
};

/// Test of the samples up to `t_end_ns`; `gravity`: G [m/s^2].
template <std::size_t Capacity>
StationarityReport stationarity(const ImuBuffer<Capacity>& buffer, TimeNs t_end_ns,
                                const StationarityOptions& options = {}, double gravity = standard_gravity<double>) {
  StationarityReport out;
  const TimeNs block_ns = static_cast<TimeNs>(options.block_s * 1e9);
  std::size_t i = buffer.first_after(t_end_ns - options.blocks * block_ns);
  double gyro_scatter = 0, accel_scatter = 0;
  for (int b = 0; b < options.blocks; ++b) {
    const TimeNs block_end = t_end_ns - (options.blocks - 1 - b) * block_ns;
    Vec<double, 3> gyro = zeros<double, 3>(), accel = zeros<double, 3>();
    int count = 0;
    for (; i < buffer.size() && buffer[i].t_ns <= block_end; ++i, ++count) {
      gyro += buffer[i].gyro;
      accel += buffer[i].accel;
    }
    if (count < options.min_block_samples) return out;
    const Vec<double, 3> dg = gyro / count - out.mean_gyro, da = accel / count - out.mean_accel;
    const double n = ++out.blocks;  // mean and scatter of the block means, updated
    out.mean_gyro += dg / n;
    out.mean_accel += da / n;
    gyro_scatter += squared_norm(dg) * (n - 1) / n;
    accel_scatter += squared_norm(da) * (n - 1) / n;
  }
  out.gyro_spread = std::sqrt(gyro_scatter / options.blocks);  // (3)
  out.accel_spread = std::sqrt(accel_scatter / options.blocks);
  if (!(out.gyro_spread <= options.gyro_spread)) {
    out.verdict = StationarityVerdict::rotating;
  } else if (!(out.accel_spread <= options.accel_spread)) {
    out.verdict = StationarityVerdict::accelerating;
  } else if (!(norm(out.mean_gyro) <= options.gyro_bias) ||
             !(std::abs(norm(out.mean_accel) - gravity) <= options.gravity_error)) {
    out.verdict = StationarityVerdict::implausible;
  } else {
    out.verdict = StationarityVerdict::stationary;
  }
  return out;
}

/// State of a stationary body by (4): at the origin, upright, with zero velocity and yaw.
template <std::floating_point S>
NavState<S> stationary_state(const StationarityReport& report, double gravity = standard_gravity<double>) {
  const Vec<double, 3> up = normalized(report.mean_accel);
  NavState<double> x;
  x.T_world_body = SE3<double>(upright<double>(-up), zeros<double, 3>());
  x.bias_gyro = report.mean_gyro;
  x.bias_accel = (norm(report.mean_accel) - gravity) * up;
  return x.cast<S>();
}

}  // namespace plumbline
