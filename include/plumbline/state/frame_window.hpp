#pragma once
/// The frames that are estimated together, with the blocks of the rig: one owner of every pose, of the estimated
/// extrinsics and of the estimated time offset.                                                     docs/math/window.md
///
/// A frame keeps its slot while it lives. The latest frame is one of them, or has a value of its own outside the
/// window.
///
/// Let T, T0 be the value and the first estimate of the newest pose that a prior refers to. A pose x that no prior
/// refers to has the linearization point
///   x0 = T0 T^-1 x,                                                                                          (3)
/// so that Jacobians contain the current pose of one frame relative to the other, whatever the common displacement of
/// the window since T0.

#include <array>
#include <cstdint>
#include <type_traits>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/frame_state.hpp"

namespace plumbline {

template <class S, class LayoutT, int Slots>
class FrameWindow {
 public:
  using Scalar = S;
  using Layout = LayoutT;
  using Value = FrameValue<S, Layout>;
  using State = FrameState<S, Layout>;
  using Extrinsics = Estimated<state::Extrinsics, S>;
  using TimeOffset = Estimated<state::TimeOffset, double>;
  static constexpr int slots = Slots;

  /// One slot of the window.
  struct Frame {
    bool used = false;
    TimeNs t_ns = 0;
    std::uint32_t sequence = 0;  ///< number of the frame since the start; larger is newer
    State state;
  };

  const Frame& operator[](int slot) const { return frames_[slot]; }
  State& state(int slot) { return frames_[slot].state; }
  const SE3<S>& T_world_body(int slot) const { return frames_[slot].state.template get<state::Pose>().value(); }
  int size() const { return size_; }
  bool full() const { return size_ == Slots; }
  /// Slot of the newest frame; valid while there is one.
  int newest() const { return newest_; }
  int oldest() const {
    int found = newest_;
    for (int k = 0; k < Slots; ++k) {
      if (frames_[k].used && frames_[k].sequence < frames_[found].sequence) found = k;
    }
    return found;
  }
  /// Slot of the newest frame among those older than `sequence`; -1 when there is none.
  int before(std::uint32_t sequence) const {
    int found = -1;
    for (int k = 0; k < Slots; ++k) {
      const Frame& frame = frames_[k];
      if (!frame.used || frame.sequence >= sequence) continue;
      if (found < 0 || frame.sequence > frames_[found].sequence) found = k;
    }
    return found;
  }

  /// Inserts a frame with value x and returns its slot. The window must not be full.
  int insert(TimeNs t_ns, const Value& x) {
    PLUMBLINE_ASSERT(!full());
    int slot = 0;
    while (frames_[slot].used) ++slot;
    frames_[slot] = {true, t_ns, ++sequence_, State(x)};
    ++size_;
    newest_ = slot;
    relate_first_estimates();
    return slot;
  }

  /// Frees a slot; at least one frame must remain. The latest frame stays the latest.
  void remove(int slot) {
    PLUMBLINE_ASSERT(frames_[slot].used && size_ > 1);
    if (slot == latest_slot_) set_latest(latest());
    frames_[slot].used = false;
    --size_;
    if (slot == newest_) newest_ = before(frames_[slot].sequence);
  }

  /// Removes all frames; extrinsics and time offset are no longer estimated.
  void clear() {
    set_latest(latest());
    for (Frame& frame : frames_) frame.used = false;
    size_ = 0;
    estimates_extrinsics_.set(false);
    estimates_time_offset_.set(false);
  }

  /// Extrinsics are estimated from now on until `clear`, beginning with `T_body_cam`.
  void estimate_extrinsics(const SE3<S>& T_body_cam) {
    Extrinsics extrinsics(T_body_cam);
    extrinsics.fix_first_estimate();
    extrinsics_.set(extrinsics);
    estimates_extrinsics_.set(true);
  }
  bool estimates_extrinsics() const { return estimates_extrinsics_.get(); }
  const Extrinsics& extrinsics() const requires has_extrinsics<Layout> { return extrinsics_.get(); }
  /// Estimated extrinsics, or `given` where they are not estimated.
  const SE3<S>& T_body_cam(const SE3<S>& given) const {
    if constexpr (has_extrinsics<Layout>) {
      if (estimates_extrinsics()) return extrinsics().value();
    }
    return given;
  }

  /// The time offset is estimated from now on until `clear`, beginning with `offset_s` [s].
  void estimate_time_offset(double offset_s) {
    TimeOffset time_offset{state::TimeOffset::Value<double>(offset_s)};
    time_offset.fix_first_estimate();
    time_offset_.set(time_offset);
    estimates_time_offset_.set(true);
  }
  bool estimates_time_offset() const { return estimates_time_offset_.get(); }
  const TimeOffset& time_offset() const requires has_time_offset<Layout> { return time_offset_.get(); }
  /// Estimated time offset, or `given` where it is not estimated [s].
  double time_offset_s(double given) const {
    if constexpr (has_time_offset<Layout>) {
      if (estimates_time_offset()) return time_offset().value()[0];
    }
    return given;
  }

  /// Adds increments: `step` has those of all slots one after the other, then those of the rig.
  void move(const auto& step) {
    int at = 0;
    const auto take = [&](auto& estimated, int block_at) {
      typename std::remove_reference_t<decltype(estimated)>::Step d;
      for (int c = 0; c < int(d.size()); ++c)
        d[c] = static_cast<std::remove_reference_t<decltype(d[0])>>(step[block_at + c]);
      estimated.add(d);
    };
    for (Frame& frame : frames_) {
      if (frame.used) take(frame.state, at);
      at += Layout::dim;
    }
    relate_first_estimates();
    if constexpr (has_extrinsics<Layout>) {
      using Rig = RigLayout<Layout>;
      Extrinsics extrinsics = extrinsics_.get();
      TimeOffset time_offset = time_offset_.get();
      if (estimates_extrinsics()) take(extrinsics, at + Rig::template offset<state::Extrinsics>);
      if (estimates_time_offset()) take(time_offset, at + Rig::template offset<state::TimeOffset>);
      extrinsics_.set(extrinsics);
      time_offset_.set(time_offset);
    }
  }

  /// The poses of all frames, and their linearization points, in another world: x_new = T_new_old x_old.
  void transform(const SE3<S>& T_new_old) {
    for (Frame& frame : frames_) {
      if (frame.used) frame.state.template get<state::Pose>().transform(T_new_old);
    }
  }

  /// The state of the latest frame.
  Value latest() const { return latest_slot_ < 0 ? latest_value_ : frames_[latest_slot_].state.value(); }
  void set_latest(int slot) { latest_slot_ = slot; }
  void set_latest(const Value& x) {
    latest_value_ = x;
    latest_slot_ = -1;
  }

 private:
  using Pose = Estimated<state::Pose, S>;

  /// Sets the first estimates of poses without a prior, (3).
  void relate_first_estimates() {
    const Frame* newest = nullptr;
    for (const Frame& frame : frames_) {
      if (frame.used && frame.state.template get<state::Pose>().is_fixed() &&
          (!newest || frame.sequence > newest->sequence))
        newest = &frame;
    }
    if (!newest) return;
    const Pose& known = newest->state.template get<state::Pose>();
    const SE3<S> to_first = known.first_estimate() * known.value().inverse();
    for (Frame& frame : frames_) {
      Pose& pose = frame.state.template get<state::Pose>();
      if (frame.used && !pose.is_fixed()) pose = Pose(pose.value(), to_first * pose.value());
    }
  }

  std::array<Frame, Slots> frames_{};
  int size_ = 0;
  int newest_ = 0;
  int latest_slot_ = -1;  ///< -1: the latest frame is not in the window
  Value latest_value_;    ///< value of the latest frame when it is not in the window
  std::uint32_t sequence_ = 0;
  [[no_unique_address]] Present<Extrinsics, has_extrinsics<Layout>> extrinsics_;
  [[no_unique_address]] Present<bool, has_extrinsics<Layout>> estimates_extrinsics_;
  [[no_unique_address]] Present<TimeOffset, has_time_offset<Layout>> time_offset_;
  [[no_unique_address]] Present<bool, has_time_offset<Layout>, 1> estimates_time_offset_;
};

}  // namespace plumbline
