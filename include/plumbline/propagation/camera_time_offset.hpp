#pragma once
/// The time offset between camera and IMU, t_imu = t_image + offset, and the boundaries of the samples of each frame.
///                                                                                docs/math/camera_imu.md
/// Before initialization the offset is estimated by CameraImuFilter, afterwards by the window. A new value is used from
/// the next frame on; the boundaries of earlier frames keep the offset they were computed with.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/residual/time_offset_shift.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

/// The time at which the samples of a frame end and those of the next frame begin.
template <class S>
struct SampleBoundary {
  double offset_s = 0;             ///< time offset with which the boundary was computed [s]
  Vec<S, 3> gyro = zeros<S, 3>();  ///< mean gyroscope sample just before the boundary [rad/s]

  /// Shift from the image to the boundary when the offset is offset_s_now.         docs/math/camera_imu.md (4)
  TimeOffsetShift<S> shift(double offset_s_now) const { return {S(offset_s_now - offset_s), gyro}; }
};

template <class S>
class CameraTimeOffset {
 public:
  explicit CameraTimeOffset(double calibrated_s)
      : boundary_{calibrated_s}, previous_(boundary_), keyframe_(boundary_) {}

  double offset_s() const { return boundary_.offset_s; }
  const SampleBoundary<S>& boundary() const { return boundary_; }  ///< of the latest frame
  const SampleBoundary<S>& previous() const { return previous_; }  ///< of the previous frame
  const SampleBoundary<S>& keyframe() const { return keyframe_; }  ///< begin of the IMU factor to the latest frame

  /// Updates the offset for the next frame: by the filter, or by the window, at most max_step_s [s] at a time.
  void calibrate(auto& filter, const auto& window, bool in_window, double max_step_s) {
    previous_ = boundary_;
    if (in_window) {
      shift(filter, std::clamp(window.time_offset_s(offset_s()) - offset_s(), -max_step_s, max_step_s));
    } else {
      boundary_.offset_s += filter.take_time_offset();
    }
  }
  void set_gyro(const Vec<S, 3>& gyro) { boundary_.gyro = gyro; }
  void begin_factor() { keyframe_ = boundary_; }
  /// The IMU factor to the latest frame begins at the previous frame.
  void begin_factor_at_previous() { keyframe_ = previous_; }
  /// The state of the previous frame, shifted to the boundary where the samples of this frame begin.
  NavState<S> at_boundary(const NavState<S>& before) const { return previous_.shift(offset_s())(before); }

  /// Takes back the corrections by the window, which may be wrong after a failure.
  void reset_window_correction(auto& filter) { shift(filter, -window_correction_s_); }

 private:
  void shift(auto& filter, double step_s) {
    filter.shift_time_offset(step_s);
    boundary_.offset_s += step_s;
    window_correction_s_ += step_s;
  }

  SampleBoundary<S> boundary_, previous_, keyframe_;
  double window_correction_s_ = 0;  ///< part of the offset that the window has estimated [s]
};

}  // namespace plumbline
