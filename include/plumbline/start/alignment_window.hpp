#pragma once
/// What an estimator with an IMU gathers before it knows scale, gravity, velocity and biases: the newest camera poses
/// at regular intervals, with the IMU's increments between them.                     docs/math/inertial_window.md

#include <array>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/preintegration.hpp"

namespace plumbline {

template <class S>
class AlignmentWindow {
 public:
  static constexpr int capacity = 24;
  using Increment = Preintegration<S, 64>;
  using Outcome = InertialAlignment<S, capacity>;

  void clear() { frames_.clear(); }

  /// One frame, with the readings since the one before. True when it became one of the poses.
  template <std::size_t N>
  bool add(const SE3<S>& T_ref_cam, const Preintegration<S, N>& since_last, double interval_s) {
    if (frames_.empty()) {
      frames_.push_back({T_ref_cam, Increment(since_last.noise())});
      pending_ = Increment(since_last.noise());
      return true;
    }
    for (const ImuInterval<S>& interval : since_last.intervals()) pending_.add(interval);
    if (pending_.increment().duration < S(interval_s)) return false;
    if (frames_.full()) {
      for (std::size_t i = 1; i < frames_.size(); ++i) frames_[i - 1] = frames_[i];
      frames_.resize(frames_.size() - 1);
    }
    frames_.push_back({T_ref_cam, pending_});
    pending_ = Increment(since_last.noise());
    return true;
  }

  Outcome align(const SE3<S>& T_body_cam, const InertialAlignmentOptions& options, double gravity) {
    std::array<AlignmentFrame<Increment>, capacity> frames;
    for (std::size_t i = 0; i < frames_.size(); ++i) frames[i] = {frames_[i].T_ref_cam, &frames_[i].increment};
    return align_inertial<capacity, Increment>(
        std::span<const AlignmentFrame<Increment>>(frames.data(), frames_.size()), T_body_cam, options, gravity);
  }

 private:
  struct Entry {
    SE3<S> T_ref_cam;
    Increment increment;
  };

  FixedVector<Entry, capacity> frames_;
  Increment pending_;
};

}  // namespace plumbline
