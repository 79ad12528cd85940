#pragma once
/// Detects, while a second view is awaited, that the body has stopped at some distance from its first view, or that the
/// tracks of a stationary body drift. Either way a new first view is needed.

#include <cmath>

#include "plumbline/core/time.hpp"

namespace plumbline {

class StopDetector {
 public:
  /// With the options of a propagation that detects stationarity; without them nothing is detected.
  explicit StopDetector(const auto& propagation) {
    if constexpr (requires { propagation.stationary_motion_px; }) {
      motion_px_ = propagation.stationary_motion_px;
      check_s_ = propagation.stationary_check_s;
    }
  }

  /// Whether tracks of a stationary body have drifted by `track_px` [px] too far.
  bool has_drifted(double track_px) const { return track_px > motion_px_; }
  /// Whether the mean track length, now `track_px` [px], has been the same for the time of observation.
  bool has_stopped(TimeNs t_ns, double track_px) {
    if (!(std::abs(track_px - reference_px_) < motion_px_)) {
      reference_px_ = track_px;
      unchanged_since_ns_ = t_ns;
    }
    return seconds_between(unchanged_since_ns_, t_ns) > check_s_;
  }

 private:
  double motion_px_ = 0;           ///< mean track length that is not yet motion [px]
  double check_s_ = 0;             ///< time over which it is observed [s]
  double reference_px_ = 0;        ///< mean track length, from the first view [px]
  TimeNs unchanged_since_ns_ = 0;  ///< since when it is that of reference_px_
};

}  // namespace plumbline
