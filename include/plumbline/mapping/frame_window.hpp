#pragma once
/// The keyframes of a sliding window, each in a slot that it keeps while it lives.          docs/math/window.md
///
/// A pose that the marginalization prior touches keeps its linearization point x0 for ever and moves by a correction,
/// x = x0 [+] e (first-estimate Jacobians): increments are added to e, Jacobians are taken at x0, and the prior is
/// exactly r0 + J0 e. A new pose gets the linearization point that stands to that of the newest keyframe as it stands
/// to the newest keyframe itself,
///   x0 = T0 T^-1 x,                                                                                          (3)
/// so that Jacobians see how the two stand to each other now, however far the whole window has moved since.

#include <array>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
class WindowPose {
 public:
  WindowPose() = default;
  explicit WindowPose(const SE3<S>& T_world_body) : WindowPose(T_world_body, T_world_body) {}
  WindowPose(const SE3<S>& T_world_body, const SE3<S>& T_linear)
      : T_(T_world_body), T_linear_(T_linear), e_(minus(T_world_body, T_linear)) {}

  const SE3<S>& value() const { return T_; }
  const SE3<S>& linearization_point() const { return T_linear_; }
  /// e
  const Vec<S, 6>& correction() const { return e_; }

  void add(const Vec<S, 6>& d) {
    if (fixed_) {
      e_ += d;
      T_ = plus(T_linear_, e_);
    } else {
      *this = WindowPose(plus(T_, d), plus(T_linear_, d));
    }
  }
  /// From now on a prior refers to this linearization point.
  void fix_linearization_point() { fixed_ = true; }

 private:
  SE3<S> T_, T_linear_;
  Vec<S, 6> e_ = Vec<S, 6>::Zero();
  bool fixed_ = false;
};

template <class S, int Slots>
class FrameWindow {
 public:
  static constexpr int slots = Slots;

  struct Keyframe {
    bool used = false;
    TimeNs t_ns = 0;
    std::uint32_t sequence = 0;  ///< counts keyframes; larger is newer
    WindowPose<S> pose;
  };

  const Keyframe& operator[](int slot) const { return keyframes_[slot]; }
  WindowPose<S>& pose(int slot) { return keyframes_[slot].pose; }
  int size() const { return size_; }
  bool full() const { return size_ == Slots; }
  /// Slot of the newest keyframe; only when there is one.
  int newest() const { return newest_; }

  /// Puts a keyframe into a free slot and returns it. The window must not be full.
  int insert(TimeNs t_ns, const SE3<S>& T_world_body) {
    PLUMBLINE_ASSERT(!full());
    int slot = 0;
    while (keyframes_[slot].used) ++slot;
    WindowPose<S> pose(T_world_body);
    if (size_ > 0) {
      const WindowPose<S>& newest = keyframes_[newest_].pose;
      pose =
          WindowPose<S>(T_world_body, newest.linearization_point() * newest.value().inverse() * T_world_body);  // (3)
    }
    keyframes_[slot] = {true, t_ns, ++sequence_, pose};
    ++size_;
    newest_ = slot;
    return slot;
  }

  /// Frees a slot; not the last one.
  void remove(int slot) {
    PLUMBLINE_ASSERT(keyframes_[slot].used && size_ > 1);
    keyframes_[slot].used = false;
    --size_;
    if (slot == newest_) newest_ = before(keyframes_[slot].sequence);
  }

  /// Slot of the newest keyframe among those older than `sequence`; -1 when there is none.
  int before(std::uint32_t sequence) const {
    int found = -1;
    for (int k = 0; k < Slots; ++k) {
      const Keyframe& keyframe = keyframes_[k];
      if (!keyframe.used || keyframe.sequence >= sequence) continue;
      if (found < 0 || keyframe.sequence > keyframes_[found].sequence) found = k;
    }
    return found;
  }

  void clear() {
    for (Keyframe& keyframe : keyframes_) keyframe.used = false;
    size_ = 0;
  }

 private:
  std::array<Keyframe, Slots> keyframes_{};
  int size_ = 0;
  int newest_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace plumbline
