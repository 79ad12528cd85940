#pragma once
/// Coverage of a requested time by IMU samples. Frozen and saturated time may overlap the others.

#include <algorithm>

namespace plumbline {

struct ImuCoverage {
  bool valid = false;           ///< there were samples, and the requested time is not empty
  int intervals = 0;            ///< number of intervals
  double duration_s = 0;        ///< requested time [s]
  double gap_s = 0;             ///< interpolated over gaps [s]
  double held_s = 0;            ///< before the first or after the last sample [s]
  double frozen_s = 0;          ///< frozen samples [s]
  double saturated_s = 0;       ///< gyroscope or accelerometer saturated [s]
  double gyro_saturated_s = 0;  ///< gyroscope saturated [s]

  /// Coverage of two successive times together.
  ImuCoverage& operator+=(const ImuCoverage& next) {
    valid = valid || next.valid;
    intervals += next.intervals;
    duration_s += next.duration_s;
    gap_s += next.gap_s;
    held_s += next.held_s;
    frozen_s += next.frozen_s;
    saturated_s += next.saturated_s;
    gyro_saturated_s += next.gyro_saturated_s;
    return *this;
  }

  /// Fraction of the time without live samples, 0..1.
  double missing() const { return valid ? std::min(1.0, (gap_s + held_s + frozen_s) / duration_s) : 1; }
};

}  // namespace plumbline
