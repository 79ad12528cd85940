#pragma once
/// What is known of mount and clock of the camera of a window besides its rows; nothing without an IMU.
///                                                                                          docs/math/camera_imu.md

#include <cmath>

#include "plumbline/backend/extrinsics_prior.hpp"
#include "plumbline/backend/time_offset_prior.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/state/clock_belief.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class Layout>
class RigPrior {
 public:
  RigPrior(const ExtrinsicsOptions& extrinsics, const TimeOffsetOptions& time_offset)
      : extrinsics_(ExtrinsicsPrior(extrinsics)), options_(time_offset) {}

  /// From now on the window estimates where the camera sits, and how its clock goes unless it is known. One in doubt is
  /// as one that was just corrected.
  void begin(auto& window, const auto& T_body_cam, const ClockBelief& clock) {
    window.estimate_extrinsics(T_body_cam);
    const TimeOffsetOptions options = options_.get();
    if (clock.known || !(options.sigma_s > 0)) return;
    time_offset_.set(TimeOffsetPrior(options, clock.sigma_s));
    window.estimate_time_offset(clock.offset_s);
    clock_.set({clock.in_doubt, window[window.newest()].t_ns, 0});
  }

  /// Before the frames are solved for. What a wrong clock makes of turns looks like a turned mount as long as the body
  /// turns about one axis: while the clock is found out the mount is held.
  void watch(const auto& window) {
    if constexpr (has_time_offset<Layout>) {
      if (!window.estimates_time_offset()) return;
      const TimeOffsetOptions options = options_.get();
      const TimeNs now_ns = window[window.newest()].t_ns;
      const double correction_s = window.time_offset().correction()[0];
      Clock clock = clock_.get();
      if (std::abs(correction_s - clock.correction_s) > options.settled_s) clock = {true, now_ns, correction_s};
      clock_.set(clock);
      ExtrinsicsPrior mount = extrinsics_.get();
      mount.hold(clock.moved && seconds_between(clock.moved_ns, now_ns) < options.settling_s);
      extrinsics_.set(mount);
    }
  }

  double cost(const auto& window) const {
    double sum = 0;
    if constexpr (has_extrinsics<Layout>) {
      if (window.estimates_extrinsics())
        sum += extrinsics_.get().cost(cast_to<double>(window.extrinsics().correction()));
      if (window.estimates_time_offset()) sum += time_offset_.get().cost(window.time_offset().correction()[0]);
    }
    return sum;
  }
  /// To the equations of what is seen.
  void add_to(const auto& window, auto& equations) const {
    if constexpr (has_extrinsics<Layout>) {
      equations.add_extrinsics(window, extrinsics_.get());
      equations.add_time_offset(window, time_offset_.get());
    }
  }

 private:
  /// How it was corrected last by more than a little.
  struct Clock {
    bool moved = false;
    TimeNs moved_ns = 0;
    double correction_s = 0;
  };

  [[no_unique_address]] Present<ExtrinsicsPrior, has_extrinsics<Layout>> extrinsics_;
  [[no_unique_address]] Present<TimeOffsetOptions, has_time_offset<Layout>> options_;
  [[no_unique_address]] Present<TimeOffsetPrior, has_time_offset<Layout>> time_offset_;
  [[no_unique_address]] Present<Clock, has_time_offset<Layout>> clock_;
};

}  // namespace plumbline
