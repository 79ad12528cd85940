#include "simulate_faults.hpp"

#include <cmath>
#include <numbers>

#include "format.hpp"

namespace pl = plumbline;

pl::SO3<double> SimulateFaults::extrinsics_turn() const {
  if (extrinsics_turn_deg.size() != 3) return {};
  return pl::SO3<double>::exp(
      pl::Vec<double, 3>(extrinsics_turn_deg[0], extrinsics_turn_deg[1], extrinsics_turn_deg[2]) / degrees);
}

pl::ImuSample ImuFaults::operator()(pl::ImuSample sample, pl::TimeNs period_ns) {
  using Vector = pl::Vec<double, 3>;
  const int row = count_++;
  if (faults_.vibration.size() == 2) {
    const double angle = 2 * std::numbers::pi * faults_.vibration[1] * 1e-9 * double(period_ns) * row;
    sample.accel +=
        Vector::Constant(std::numbers::sqrt2 / std::numbers::sqrt3 * faults_.vibration[0] * std::sin(angle));
  }
  if (faults_.accel_sign) sample.accel = -sample.accel;
  const auto limit = [](Vector& value, double range) {
    if (range > 0) value = value.cwiseMin(range).cwiseMax(-range).eval();
  };
  limit(sample.gyro, faults_.gyro_range);
  limit(sample.accel, faults_.accel_range);
  if (row % faults_.held_accel == 0) held_ = sample.accel;
  sample.accel = held_;
  constexpr pl::TimeNs apart_ns = 100'000;
  const int left = faults_.bursts - 1 - row % faults_.bursts;  // of the burst, after this one
  sample.t_ns += left * (period_ns - apart_ns);
  return sample;
}
