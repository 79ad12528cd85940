#pragma once
/// The IMU samples from the last keyframe to the latest frame, and what is wrong with them. They are integrated by the
/// factor of the next keyframe (imu_factors.hpp).

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/imu_intervals.hpp"
#include "plumbline/imu/nav_state.hpp"

namespace plumbline {

template <class S>
class SamplesSinceKeyframe {
 public:
  /// A new keyframe.
  void restart() { *this = {}; }
  /// The samples before the last frame do not count any longer.
  void keep_last(const ImuIntervals<S>& since_frame) { intervals_ = since_frame; }
  /// Adds the samples of a frame. `is_unusable`: they do not determine the translation.
  void append(const ImuIntervals<S>& since_frame, bool is_unusable) {
    intervals_.append(since_frame);
    is_unusable_ = is_unusable_ || is_unusable;
  }
  /// The gyroscope bias has jumped.
  void mark_jumped() { has_jumped_ = true; }
  /// The accelerometer has been wrong: its noise is inflated by that sigma over one second [m/s^2].
  void distrust_accelerometer(S sigma) {
    intervals_.inflate_accelerometer_noise(sigma);
    is_unusable_ = true;
  }

  const ImuIntervals<S>& intervals() const { return intervals_; }
  double duration_s() const { return double(intervals_.duration()); }
  bool has_jumped() const { return has_jumped_; }
  /// Whether a factor of these samples does not determine the velocity.
  bool is_suspect() const { return is_unusable_ || has_jumped_; }

  /// Corrects the velocity of a solved state to that of the images, when the IMU has been unusable since the keyframe.
  /// The change is limited by max_accel [m/s^2].                                 docs/math/inertial_window.md (1k)
  bool correct(const NavState<S>& before, NavState<S>& solved, S dt, S max_accel) const {
    if (!is_unusable_) return false;
    const Vec<S, 3> v_images = (solved.T_world_body.p() - before.T_world_body.p()) / dt,
                    change = v_images - before.v_world_body;
    const S change_norm = norm(change), max_change = max_accel * dt;
    solved.v_world_body =
        change_norm > max_change ? Vec<S, 3>(before.v_world_body + (max_change / change_norm) * change) : v_images;
    return true;
  }

 private:
  ImuIntervals<S> intervals_;
  bool is_unusable_ = false, has_jumped_ = false;
};

}  // namespace plumbline
