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

template <Clock C>
class Stopwatch {
 public:
  /// Seconds since the last call, or since the beginning.
  double lap() {
    const double now = C::now(), passed = now - last_;
    last_ = now;
    return passed;
  }

 private:
  double last_ = C::now();
};

/// Of the last frame [s], but for work beside the caller; zero with NoClock.
struct FrameTiming {
  double pyramid = 0;   ///< and the wait for work beside the caller
  double align = 0;     ///< prediction and alignment of the image as a whole
  double follow = 0;    ///< of each feature, and what most of them agree on
  double estimate = 0;  ///< motion-only estimate
  double map = 0;       ///< solve of the frame, depth of new features; keyframe: detection, window, marginalization
  double total = 0;

  double track() const { return pyramid + align + follow; }
};

}  // namespace plumbline
