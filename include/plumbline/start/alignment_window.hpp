#pragma once
/// What an estimator with an IMU gathers before it knows scale, gravity, velocity and biases: camera poses at regular
/// intervals, with the IMU's increments between them. When there is no more room every second pose goes, so that slow
/// motion is seen over a longer time; beyond the longest interval the oldest one goes. When the camera's clock or
/// shutter turn out to be others, the poses so far are rough; they follow the clock along their own motion.
///                                                                                docs/math/inertial_window.md

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
  static constexpr int capacity = 24;
  using Increment = Preintegration<S, 64>;
  using Outcome = InertialAlignment<S, capacity>;

  void clear() {
    frames_.clear();
    doublings_ = 0;
    rough_ = 0;
  }

  /// One frame, with the readings since the one before, both cut by the same clock, and its position's own noise, see
  /// AlignmentFrame. True when it became one of the poses.
  template <std::size_t N>
  bool add(TimeNs t_ns, const SE3<S>& T_ref_cam, const Preintegration<S, N>& since_last, double interval_s,
           double time_offset_s = 0, const Mat<S, 3, 3>& position_covariance = zeros<Mat<S, 3, 3>>()) {
    if (frames_.empty()) {
      frames_.push_back({t_ns, time_offset_s, T_ref_cam, position_covariance, Increment(since_last.noise())});
      pending_ = Increment(since_last.noise());
      return true;
    }
    for (const ImuInterval<S>& interval : since_last.intervals()) pending_.add(interval);
    if (pending_.increment().duration < S(interval_s * (1 << doublings_))) return false;
    if (frames_.full()) make_room();
    frames_.push_back({t_ns, time_offset_s, T_ref_cam, position_covariance, pending_});
    pending_ = Increment(since_last.noise());
    return true;
  }

  /// The frame of that time, if it is one of the poses, turned out to be elsewhere.
  void correct(TimeNs t_ns, const SE3<S>& T_ref_cam) {
    for (Entry& entry : frames_) {
      if (entry.t_ns == t_ns) entry.T_ref_cam = T_ref_cam;
    }
  }

  /// The camera's clock or shutter were others than was thought, for all poses so far.
  void make_rough() { rough_ = frames_.size(); }
  bool has_rough() const { return rough_ > 0; }
  void forget_rough() {
    while (rough_ > 0) drop_oldest();
  }

  /// The poses contradict the readings: the longer ago, the worse vision knew the scene. Half of the window stays, a
  /// few poses would agree with anything.
  void forget_oldest() {
    forget_rough();
    if (frames_.size() > capacity / 2) drop_oldest();
  }

  /// Of all poses or of those that are not rough, with the clock as it is known now.
  Outcome align(const SE3<S>& T_body_cam, const InertialAlignmentOptions& options, double gravity,
                double time_offset_s = 0, bool with_rough = true) {
    std::array<AlignmentFrame<Increment>, capacity> frames;
    const std::size_t first = with_rough ? 0 : rough_, n = frames_.size() - first;
    for (std::size_t i = 0; i < n; ++i)
      frames[i] = {where_cut(first + i, time_offset_s), &frames_[first + i].increment,
                   frames_[first + i].position_covariance};
    return align_inertial<capacity, Increment>(std::span<const AlignmentFrame<Increment>>(frames.data(), n), T_body_cam,
                                               options, gravity);
  }

 private:
  struct Entry {
    TimeNs t_ns;
    double time_offset_s;  ///< of the camera's clock, by which the readings are cut
    SE3<S> T_ref_cam;
    Mat<S, 3, 3> position_covariance;
    Increment increment;
  };

  static constexpr int max_doublings = 2;

  /// The camera when its readings were cut: not when its image was taken, if the clock was another than thought.
  SE3<S> where_cut(std::size_t i, double time_offset_s) const {
    const Entry& entry = frames_[i];
    const Entry &before = frames_[i > 0 ? i - 1 : i], &after = frames_[i + 1 < frames_.size() ? i + 1 : i];
    const double late_s = entry.time_offset_s - time_offset_s, around_s = seconds_between(before.t_ns, after.t_ns);
    if (late_s == 0 || !(around_s > 0)) return entry.T_ref_cam;
    return plus(entry.T_ref_cam, Vec<S, 6>(minus(after.T_ref_cam, before.T_ref_cam) * S(late_s / around_s)));
  }

  void drop_oldest() {
    if (rough_ > 0) --rough_;
    for (std::size_t i = 1; i < frames_.size(); ++i) frames_[i - 1] = frames_[i];
    frames_.resize(frames_.size() - 1);
  }

  void make_room() {
    static_assert(capacity % 2 == 0);
    const std::size_t n = frames_.size();
    if (doublings_ == max_doublings || rough_ > 0) return drop_oldest();
    for (std::size_t i = 1; i < n; i += 2) {  // the last one stays
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
  Increment pending_;
  int doublings_ = 0;
  std::size_t rough_ = 0;  ///< of the oldest
};

}  // namespace plumbline
