#pragma once
/// Camera poses at regular intervals with the IMU increments between them, for visual-inertial alignment.
///                                                                                docs/math/inertial_window.md
/// When the window is full every second pose is removed and the interval doubles, twice at most, so that slow motion is
/// seen over a longer time; after that the oldest pose is removed. Poses from before a change of the time offset or of
/// the readout time are outdated. They follow a change of the offset along their own motion, see camera_at_boundary.

#include <array>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/lie/plus.hpp"

namespace plumbline {

template <class S>
class AlignmentWindow {
 public:
  static constexpr int capacity = 24;  ///< largest number of poses; tuned: docs/decisions/132 (chosen)
  using Increment = Preintegration<S, 64>;
  using Outcome = InertialAlignment<S, capacity>;

  void clear() {
    frames_.clear();
    doublings_ = 0;
    outdated_ = 0;
  }

  /// Adds a frame, with the increment since the previous frame and the covariance of its position by its own features
  /// (AlignmentFrame). Returns whether it became one of the poses.
  template <std::size_t N>
  bool add(TimeNs t_ns, const SE3<S>& T_ref_cam, const Preintegration<S, N>& since_last, double interval_s,
           double time_offset_s = 0, const Mat<S, 3, 3>& position_covariance = zeros<Mat<S, 3, 3>>()) {
    if (frames_.empty()) {
      frames_.push_back({t_ns, time_offset_s, T_ref_cam, position_covariance, Increment(since_last.noise())});
      pending_ = {};
      return true;
    }
    pending_.append(since_last.intervals());
    if (pending_.duration() < S(interval_s * (1 << doublings_))) return false;
    if (frames_.full()) make_room();
    frames_.push_back({t_ns, time_offset_s, T_ref_cam, position_covariance, Increment(since_last.noise(), pending_)});
    pending_ = {};
    return true;
  }

  /// Replaces the pose of the frame of that time, if it is in the window.
  void correct(TimeNs t_ns, const SE3<S>& T_ref_cam) {
    for (Entry& entry : frames_) {
      if (entry.t_ns == t_ns) entry.T_ref_cam = T_ref_cam;
    }
  }

  /// All poses so far are outdated: time offset or readout time have changed.
  void mark_outdated() { outdated_ = frames_.size(); }
  bool has_outdated() const { return outdated_ > 0; }
  void discard_outdated() {
    while (outdated_ > 0) drop_oldest();
  }

  /// Removes outdated poses and, down to half of the capacity, the oldest one. For poses that contradict the IMU: the
  /// oldest are the least accurate; too few poses would be consistent with anything.
  void discard_oldest() {
    discard_outdated();
    if (frames_.size() > capacity / 2) drop_oldest();
  }

  /// Aligns all poses, or those that are not outdated, by the given time offset.
  Outcome align(const SE3<S>& T_body_cam, const InertialAlignmentOptions& options, double gravity,
                double time_offset_s = 0, bool with_outdated = true) {
    std::array<AlignmentFrame<Increment>, capacity> frames;
    const std::size_t first = with_outdated ? 0 : outdated_, n = frames_.size() - first;
    for (std::size_t i = 0; i < n; ++i)
      frames[i] = {camera_at_boundary(first + i, time_offset_s), &frames_[first + i].increment,
                   frames_[first + i].position_covariance};
    return align_inertial<capacity, Increment>(std::span<const AlignmentFrame<Increment>>(frames.data(), n), T_body_cam,
                                               options, gravity);
  }

 private:
  struct Entry {
    TimeNs t_ns;
    double time_offset_s;  ///< with which the boundaries of the increment were computed [s]
    SE3<S> T_ref_cam;
    Mat<S, 3, 3> position_covariance;
    Increment increment;
  };

  static constexpr int max_doublings = 2;  ///< of the interval of the poses; tuned: docs/decisions/132 (chosen)

  /// The camera pose at the boundary of the samples: displaced from that of the image by the change of the time offset,
  /// along a straight line from the previous to the next pose.                     docs/math/camera_imu.md
  SE3<S> camera_at_boundary(std::size_t i, double time_offset_s) const {
    const Entry& entry = frames_[i];
    const Entry &before = frames_[i > 0 ? i - 1 : i], &after = frames_[i + 1 < frames_.size() ? i + 1 : i];
    const double shift_s = entry.time_offset_s - time_offset_s, span_s = seconds_between(before.t_ns, after.t_ns);
    if (shift_s == 0 || !(span_s > 0)) return entry.T_ref_cam;
    return plus(entry.T_ref_cam, Vec<S, 6>(minus(after.T_ref_cam, before.T_ref_cam) * S(shift_s / span_s)));
  }

  void drop_oldest() {
    if (outdated_ > 0) --outdated_;
    for (std::size_t i = 1; i < frames_.size(); ++i) frames_[i - 1] = frames_[i];
    frames_.resize(frames_.size() - 1);
  }

  void make_room() {
    static_assert(capacity % 2 == 0);
    const std::size_t n = frames_.size();
    if (doublings_ == max_doublings || outdated_ > 0) return drop_oldest();
    for (std::size_t i = 1; i < n; i += 2) {  // the newest one is kept
      Entry& kept = frames_[i / 2];
      Increment increment = frames_[i - 1].increment;
      increment.append(frames_[i].increment);
      kept = {frames_[i].t_ns, frames_[i].time_offset_s, frames_[i].T_ref_cam, frames_[i].position_covariance,
              increment};
    }
    frames_.resize(n / 2);
    ++doublings_;
  }

  FixedVector<Entry, capacity> frames_;
  typename Increment::Intervals pending_;  ///< since the newest pose
  int doublings_ = 0;
  std::size_t outdated_ = 0;  ///< number of outdated poses, the oldest ones
};

}  // namespace plumbline
