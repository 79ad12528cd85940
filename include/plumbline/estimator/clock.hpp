#pragma once
/// Where the time of a frame goes. The clock is a policy: firmware has its own, and without one nothing is measured.

#include <concepts>

namespace plumbline {

/// Seconds since an arbitrary moment.
template <class C>
concept Clock = requires {
  { C::now() } -> std::same_as<double>;
};

struct NoClock {
  static constexpr double now() { return 0; }
};

/// Of the last frame [s], but for work beside the caller; zero with NoClock.
struct FrameTiming {
  double track = 0;     ///< wait for work beside the caller, pyramid, tracking, outlier rejection, alignment
  double estimate = 0;  ///< motion-only estimate
  double map = 0;       ///< keyframe: detection, window, marginalization
  double total = 0;
};

}  // namespace plumbline
