#pragma once
/// Does the sensor stand still, and what follows from that.                           docs/math/initialization.md
///
/// The readings of the last second are averaged in blocks of 0.1 s: rotors and motors shake a robot at rest far above
/// 10 Hz, motion lasts longer. At rest the block means do not spread:
///   spread = sqrt(mean |m_b - mean m|^2)  below a limit, for both sensors                                       (3)
/// and the mean readings can be a bias and gravity. Steady motion in a straight line looks the same to an IMU: combine
/// it with what the images show.
///   at rest:  b_g = mean w,   g_body = -mean a,   b_a = (|mean a| - G) mean a/|mean a|  (its visible part)        (4)

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

struct StandstillOptions {
  int blocks = 10;
  double block_s = 0.1;        ///< [s]
  int min_block_samples = 3;   ///< in each block
  double gyro_spread = 0.012;  ///< [rad/s]
  double accel_spread = 0.2;   ///< [m/s^2]
  double gyro_bias = 0.2;      ///< largest that is believed [rad/s]
  double gravity_error = 0.5;  ///< largest | |mean a| - G | [m/s^2]
};

/// Whether at rest, or what speaks against it.
enum class StandstillVerdict : std::uint8_t { at_rest, too_few_samples, rotating, accelerating, implausible };

/// For logs.
constexpr const char* name_of(StandstillVerdict verdict) {
  switch (verdict) {
    case StandstillVerdict::at_rest: return "at rest";
    case StandstillVerdict::too_few_samples: return "too few samples";
    case StandstillVerdict::rotating: return "rotating";
    case StandstillVerdict::accelerating: return "accelerating";
    case StandstillVerdict::implausible: return "readings beyond any bias";
  }
  return "unknown verdict";
}

struct StandstillReport {
  StandstillVerdict verdict = StandstillVerdict::too_few_samples;
  int blocks = 0;
  Vec<double, 3> mean_gyro = zeros<double, 3>();   ///< [rad/s]
  Vec<double, 3> mean_accel = zeros<double, 3>();  ///< [m/s^2]
  double gyro_spread = 0, accel_spread = 0;        ///< (3)

  bool at_rest() const { return verdict == StandstillVerdict::at_rest; }
};

/// The time up to t_end_ns; `gravity` [m/s^2] is what the accelerometer of a body at rest shows.
template <std::size_t Capacity>
StandstillReport standstill(const ImuBuffer<Capacity>& buffer, TimeNs t_end_ns, const StandstillOptions& options = {},
                            double gravity = standard_gravity<double>) {
  StandstillReport out;
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
    out.verdict = StandstillVerdict::rotating;
  } else if (!(out.accel_spread <= options.accel_spread)) {
    out.verdict = StandstillVerdict::accelerating;
  } else if (!(norm(out.mean_gyro) <= options.gyro_bias) ||
             !(std::abs(norm(out.mean_accel) - gravity) <= options.gravity_error)) {
    out.verdict = StandstillVerdict::implausible;
  } else {
    out.verdict = StandstillVerdict::at_rest;
  }
  return out;
}

/// (4): the state at the origin, upright, without velocity and yaw.
template <std::floating_point S>
NavState<S> state_at_rest(const StandstillReport& report, double gravity = standard_gravity<double>) {
  const Vec<double, 3> up = normalized(report.mean_accel);
  NavState<double> x;
  x.T_world_body = SE3<double>(upright<double>(-up), zeros<double, 3>());
  x.bias_gyro = report.mean_gyro;
  x.bias_accel = (norm(report.mean_accel) - gravity) * up;
  return x.cast<S>();
}

}  // namespace plumbline
