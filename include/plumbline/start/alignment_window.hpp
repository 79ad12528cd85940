#pragma once
/// What an estimator with an IMU gathers before it knows scale, gravity, velocity and biases: camera poses at regular
/// intervals, with the IMU's increments between them. When there is no more room every second pose goes, so that slow
/// motion is seen over a longer time; beyond the longest interval the oldest one goes. docs/math/inertial_window.md

#include <array>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/preintegration.hpp"

namespace plumbline {

template <class S>
class AlignmentWindow {
 public:
  static constexpr int capacity = 24;
  using Increment = Preintegration<S, 64>;
  using Outcome = InertialAlignment<S, capacity>;

  void clear() {
    frames_.clear();
    doublings_ = 0;
  }

  /// One frame, with the readings since the one before. True when it became one of the poses.
  template <std::size_t N>
  bool add(TimeNs t_ns, const SE3<S>& T_ref_cam, const Preintegration<S, N>& since_last, double interval_s) {
    if (frames_.empty()) {
      frames_.push_back({t_ns, T_ref_cam, Increment(since_last.noise())});
      pending_ = Increment(since_last.noise());
      return true;
    }
    for (const ImuInterval<S>& interval : since_last.intervals()) pending_.add(interval);
    if (pending_.increment().duration < S(interval_s * (1 << doublings_))) return false;
    if (frames_.full()) make_room();
    frames_.push_back({t_ns, T_ref_cam, pending_});
    pending_ = Increment(since_last.noise());
    return true;
  }

  /// The frame of that time, if it is one of the poses, turned out to be elsewhere.
  void correct(TimeNs t_ns, const SE3<S>& T_ref_cam) {
    for (Entry& entry : frames_) {
      if (entry.t_ns == t_ns) entry.T_ref_cam = T_ref_cam;
    }
  }

  /// The poses contradict the readings: the longer ago, the worse vision knew the scene. Half of the window stays, a few
  /// poses would agree with anything.
  void forget_oldest() {
    if (frames_.size() > capacity / 2) drop_oldest();
  }

  Outcome align(const SE3<S>& T_body_cam, const InertialAlignmentOptions& options, double gravity) {
    std::array<AlignmentFrame<Increment>, capacity> frames;
    for (std::size_t i = 0; i < frames_.size(); ++i) frames[i] = {frames_[i].T_ref_cam, &frames_[i].increment};
    return align_inertial<capacity, Increment>(
        std::span<const AlignmentFrame<Increment>>(frames.data(), frames_.size()), T_body_cam, options, gravity);
  }

 private:
  struct Entry {
    TimeNs t_ns;
    SE3<S> T_ref_cam;
    Increment increment;
  };

  static constexpr int max_doublings = 2;

  void drop_oldest() {
    for (std::size_t i = 1; i < frames_.size(); ++i) frames_[i - 1] = frames_[i];
    frames_.resize(frames_.size() - 1);
  }

  void make_room() {
    static_assert(capacity % 2 == 0);
    const std::size_t n = frames_.size();
    if (doublings_ == max_doublings) return drop_oldest();
    for (std::size_t i = 1; i < n; i += 2) {  // the last one stays
      Entry& kept = frames_[i / 2];
      Increment increment = frames_[i - 1].increment;
      increment.append(frames_[i].increment);
      kept = {frames_[i].t_ns, frames_[i].T_ref_cam, increment};
    }
    frames_.resize(n / 2);
    ++doublings_;
  }

  FixedVector<Entry, capacity> frames_;
  Increment pending_;
  int doublings_ = 0;
};

}  // namespace plumbline
