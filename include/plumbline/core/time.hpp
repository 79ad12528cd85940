#pragma once
/// Time: int64 nanoseconds of one clock. Differences become seconds only after the subtraction, so no digit is lost.

#include <cstdint>

namespace plumbline {

using TimeNs = std::int64_t;

constexpr double seconds_between(TimeNs from, TimeNs to) { return static_cast<double>(to - from) * 1e-9; }

}  // namespace plumbline
