#pragma once
/// Counts of the IMU samples that a buffer was given, by what became of them (imu/imu_buffer.hpp).

#include <cstdint>

namespace plumbline {

struct ImuCounts {
  std::int64_t accepted = 0, not_finite = 0, clock_jumps = 0, saturated = 0, frozen = 0;
  std::int64_t reordered = 0;  ///< inserted before a newer sample
  std::int64_t repeated = 0;   ///< rejected: there is a sample of that time
  std::int64_t late = 0;       ///< of a time already used by a frame: rejected unless it is the newest
};

}  // namespace plumbline
