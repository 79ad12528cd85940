#pragma once
/// Timing of the stages of a frame. The clock is a policy; with NoClock, the default, no time is read.

#include <concepts>

namespace plumbline {

/// A source of time: seconds since an arbitrary epoch.
template <class C>
concept Clock = requires {
  { C::now() } -> std::same_as<double>;
};

struct NoClock {
  static constexpr double now() { return 0; }
};

template <Clock C>
class Stopwatch {
 public:
  /// Seconds since the last call, or since construction.
  double lap() {
    const double now = C::now(), passed = now - last_;
    last_ = now;
    return passed;
  }

 private:
  double last_ = C::now();
};

/// Durations of the stages of the last frame [s], without work on other threads; zero with NoClock.
struct FrameTiming {
  double pyramid = 0;   ///< image pyramid, and waiting for the keyframe task of the previous frame
  double align = 0;     ///< prediction and alignment of the whole image
  double follow = 0;    ///< tracking of each feature, and RANSAC consensus
  double estimate = 0;  ///< motion-only pose estimation
  double map = 0;       ///< window solution, depth of new landmarks; keyframe: detection, marginalization
  double total = 0;

  double track() const { return pyramid + align + follow; }
};

}  // namespace plumbline
