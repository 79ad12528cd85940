#pragma once
/// How the camera's clock goes against the IMU's, and by which time offset the readings of each frame were cut.
///                                                                                docs/math/camera_imu.md
/// Until frames and readings are solved for together, how images and readings turn says it (CameraImuFilter), then the
/// window: from the next frame on it is cut by what was found, and the window knows by which it cut those before.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/residual/clock_shift.hpp"
#include "plumbline/state/clock_belief.hpp"

namespace plumbline {

/// Where the readings of two frames part.
template <class S>
struct ReadingCut {
  double offset_s = 0;             ///< of the camera's clock, as it was taken for then
  Vec<S, 3> gyro = zeros<S, 3>();  ///< readings just before [rad/s]

  /// From the image to the cut, the offset being another.
  ClockShift<S> shift(double offset_s_now) const { return {S(offset_s_now - offset_s), gyro}; }
};

template <class S>
class CameraClock {
 public:
  explicit CameraClock(double calibrated_s) : cut_{calibrated_s}, previous_(cut_), keyframe_(cut_) {}

  double offset_s() const { return cut_.offset_s; }
  const ReadingCut<S>& cut() const { return cut_; }            ///< of the latest frame
  const ReadingCut<S>& previous() const { return previous_; }  ///< of the one before
  const ReadingCut<S>& keyframe() const { return keyframe_; }  ///< where the link to the latest frame begins

  /// The next frame is cut by what the filter says, or once there is one, and with its steps, the window.
  void calibrate(auto& filter, const auto& window, bool in_window, double max_step_s) {
    previous_ = cut_;
    if (in_window) {
      turn(filter, std::clamp(window.time_offset_s(offset_s()) - offset_s(), -max_step_s, max_step_s));
    } else {
      cut_.offset_s += filter.take_time_offset();
    }
  }
  void set_gyro(const Vec<S, 3>& gyro) { cut_.gyro = gyro; }
  void begin_link() { keyframe_ = cut_; }
  /// The link begins with the frame before.
  void begin_link_before() { keyframe_ = previous_; }
  /// The state of the frame before where the readings since then begin.
  NavState<S> at_cut(const NavState<S>& before) const { return previous_.shift(offset_s())(before); }

  /// All begins anew: where an estimate went wrong, its clock may have.
  void forget_window(auto& filter) { turn(filter, -by_window_s_); }

 private:
  void turn(auto& filter, double step_s) {
    filter.turn_clock(step_s);
    cut_.offset_s += step_s;
    by_window_s_ += step_s;
  }

  ReadingCut<S> cut_, previous_, keyframe_;
  double by_window_s_ = 0;  ///< of the offset
};

}  // namespace plumbline
