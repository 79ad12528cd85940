#pragma once
/// Priors on extrinsics and time offset of the camera of a window, besides its marginalization prior; empty without an
/// IMU.
///                                                                                          docs/math/camera_imu.md

#include <cmath>

#include "plumbline/backend/extrinsics_prior.hpp"
#include "plumbline/backend/time_offset_prior.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/state/layout.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

template <class Layout>
class RigPrior {
 public:
  RigPrior(const ExtrinsicsOptions& extrinsics, const TimeOffsetOptions& time_offset)
      : extrinsics_(ExtrinsicsPrior(extrinsics)), options_(time_offset) {}

  /// The window estimates the extrinsics from now on, and the time offset unless it is fixed. A suspect offset is
  /// treated like one that was just corrected.
  void begin(auto& window, const auto& T_body_cam, const TimeOffsetEstimate& time_offset) {
    window.estimate_extrinsics(T_body_cam);
    const TimeOffsetOptions options = options_.get();
    if (time_offset.is_known || !(options.sigma_s > 0)) return;
    time_offset_.set(TimeOffsetPrior(options, time_offset.sigma_s));
    window.estimate_time_offset(time_offset.offset_s);
    change_.set({time_offset.is_suspect, window[window.newest()].t_ns, 0});
  }

  /// To be called before each solution: holds the extrinsics while the time offset converges. With rotation about one
  /// axis a wrong offset and wrong extrinsics are not distinguishable.
  void update_hold(const auto& window) {
    if constexpr (has_time_offset<Layout>) {
      if (!window.estimates_time_offset()) return;
      const TimeOffsetOptions options = options_.get();
      const TimeNs now_ns = window[window.newest()].t_ns;
      const double correction_s = window.time_offset().correction()[0];
      OffsetChange change = change_.get();
      if (std::abs(correction_s - change.correction_s) > options.min_change_s) change = {true, now_ns, correction_s};
      change_.set(change);
      ExtrinsicsPrior extrinsics = extrinsics_.get();
      extrinsics.hold(change.moved && seconds_between(change.moved_ns, now_ns) < options.hold_extrinsics_s);
      extrinsics_.set(extrinsics);
    }
  }

  /// Sum of both priors.
  double cost(const auto& window) const {
    double sum = 0;
    if constexpr (has_extrinsics<Layout>) {
      if (window.estimates_extrinsics())
        sum += extrinsics_.get().cost(cast_to<double>(window.extrinsics().correction()));
      if (window.estimates_time_offset()) sum += time_offset_.get().cost(window.time_offset().correction()[0]);
    }
    return sum;
  }
  /// Adds both priors to the equations of the visual rows.
  void add_to(const auto& window, auto& equations) const {
    if constexpr (has_extrinsics<Layout>) {
      equations.add_extrinsics(window, extrinsics_.get());
      equations.add_time_offset(window, time_offset_.get());
    }
  }

 private:
  /// The last correction of the offset by more than `min_change_s`.
  struct OffsetChange {
    bool moved = false;
    TimeNs moved_ns = 0;
    double correction_s = 0;
  };

  [[no_unique_address]] Present<ExtrinsicsPrior, has_extrinsics<Layout>> extrinsics_;
  [[no_unique_address]] Present<TimeOffsetOptions, has_time_offset<Layout>> options_;
  [[no_unique_address]] Present<TimeOffsetPrior, has_time_offset<Layout>> time_offset_;
  [[no_unique_address]] Present<OffsetChange, has_time_offset<Layout>> change_;
};

}  // namespace plumbline
