#pragma once
/// The inertial sensor of a simulated recording.
///
///   gyro  = w_body + b_g + n_g,   accel = R^T (a - g) + b_a + n_a                                               (1)
///   n ~ N(0, density^2 rate),     b_{k+1} = b_k + N(0, walk^2 / rate)                                           (2)

#include <cmath>
#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/noise.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/trajectory.hpp"

namespace plumbline::testing {

/// Sensor noise and the spread of the biases at the start.
struct ImuQuality {
  ImuNoise noise;
  double gyro_bias_sigma = 0.02;   ///< [rad/s]
  double accel_bias_sigma = 0.08;  ///< [m/s^2]

  /// Exact measurements at that rate.
  static ImuQuality perfect(double rate_hz = 200) { return {{0, 0, 0, 0, rate_hz}, 0, 0}; }
};

class SimulatedImu {
 public:
  struct Measurement {
    double t = 0;  ///< [s]
    Vec<double, 3> gyro, accel;
    Vec<double, 3> gyro_bias, accel_bias;  ///< truth at t
    MotionState motion;                    ///< truth at t
    ImuSample sample(TimeNs t_start_ns) const {
      return {t_start_ns + static_cast<TimeNs>(std::llround(t * 1e9)), gyro, accel};
    }
  };

  SimulatedImu(const ImuQuality& quality, std::uint64_t seed) : noise_(quality.noise), normal_(stream_seed(seed, 4)) {
    gyro_bias_ = quality.gyro_bias_sigma * normal_.vector<3>();
    accel_bias_ = quality.accel_bias_sigma * normal_.vector<3>();
  }

  /// The next measurement: numbers 0, 1, ... are taken at t = number / rate.
  Measurement next(const Trajectory& trajectory) {
    const double rate = noise_.rate_hz, root = std::sqrt(rate);
    Measurement out;
    out.t = static_cast<double>(count_++) / rate;
    out.motion = trajectory.at(out.t);
    out.gyro_bias = gyro_bias_;
    out.accel_bias = accel_bias_;
    out.gyro = out.motion.w_body + gyro_bias_ + noise_.gyro_density * root * normal_.vector<3>();  // (1)
    out.accel = out.motion.specific_force() + accel_bias_ + noise_.accel_density * root * normal_.vector<3>();
    gyro_bias_ += noise_.gyro_walk / root * normal_.vector<3>();  // (2)
    accel_bias_ += noise_.accel_walk / root * normal_.vector<3>();
    return out;
  }

 private:
  ImuNoise noise_;
  Gaussian normal_;
  Vec<double, 3> gyro_bias_, accel_bias_;
  std::int64_t count_ = 0;
};

}  // namespace plumbline::testing
