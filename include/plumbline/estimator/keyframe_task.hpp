#pragma once
/// The keyframe task: detection, window optimization and marginalization, which make a frame a keyframe. With
/// SynchronousExecutor it is done before the frame's pose is published. With another executor each frame is solved for
/// as one that is no keyframe, and published; the task then runs beside the caller, and the next frame waits for it.
///
/// The task has exclusive access to the components while it runs. What can be asked for meanwhile is copied: the
/// published estimate (Publisher), and here the state about which IMU samples are integrated and the frame's depth image.
/// So estimates depend on frames and IMU samples, and not on the time at which the task runs.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

/// A frame with IMU factors has been solved for with the window: the navigation state follows.
template <class Parts, class MapT>
void accept_in_window(const Components<Parts, MapT>& on, const View<typename Parts::Sensors>& view) {
  on.tracker.images().keep(view, on.window.frames().latest().T_world_body);
  on.window.accept_latest(on.motion, on.navigation, on.report);
  on.tracker.set_usable(view.t_ns);
  on.window.update_covariance(on.motion, on.navigation);
}

template <class Parts, class MapT, Executor E>
class KeyframeTask {
  using On = Components<Parts, MapT>;
  using Sensors = typename Parts::Sensors;
  using State = typename Parts::Motion::State;

 public:
  KeyframeTask() = default;
  KeyframeTask(const KeyframeTask&) = delete;
  KeyframeTask& operator=(const KeyframeTask&) = delete;
  ~KeyframeTask() { wait(); }

  /// Inserts a frame with IMU factors in the state x into the window and solves for it.
  void solve_in_window(const On& on, const View<Sensors>& view, const State& x) {
    previous_state_ = on.window.frames().latest();
    if (on.window.insert(view, x, on.motion)) planned_ = Planned::keep_as_keyframe;
    on.window.solve(view, previous_state_, /*keyframe=*/false, on.tracker, on.motion, on.rig_state);
    if (planned_ == Planned::nothing) on.tracker.locate(view, on.window.frames(), on.window.landmarks());
    accept_in_window(on, view);
  }
  /// Makes the latest frame, which has a pose but no IMU factors, a keyframe.
  void make_keyframe(const On&, const View<Sensors>&) { planned_ = Planned::make_keyframe; }

  /// Whether the frame becomes a keyframe after it is published.
  bool is_planned() const { return planned_ != Planned::nothing; }
  /// Starts the task, if there is one. The frame has been published.
  void end_frame(const On& on, const View<Sensors>& view) {
    latest_state_ = on.window.frames().latest();
    if (!is_planned()) return;
    on_.emplace(on);
    view_.emplace(view);
    copy_depth();
    executor_.start([](void* self) { static_cast<KeyframeTask*>(self)->run(); }, this);
  }
  void wait() const { executor_.wait(); }

  const State& latest_state(const auto& /*window*/) const { return latest_state_; }

 private:
  enum class Planned : std::uint8_t { nothing, make_keyframe, keep_as_keyframe };

  void run() {
    On& on = *on_;
    if (planned_ == Planned::make_keyframe) {
      on.window.make_keyframe(*view_, on.tracker, on.motion, on.rig_state, on.navigation);
    } else {
      on.window.solve(*view_, previous_state_, /*keyframe=*/true, on.tracker, on.motion, on.rig_state);
      on.tracker.locate(*view_, on.window.frames(), on.window.landmarks());
      on.window.keep_as_keyframe(*view_, on.tracker, on.motion, on.navigation);
    }
    planned_ = Planned::nothing;
  }

  /// Copies the depth image: the caller's pixels are not used after add_frame.
  void copy_depth() {
    if constexpr (Sensors::has_depth) {
      auto& depth = view_->depth;
      if (depth.empty()) return;
      for (int v = 0; v < depth.height; ++v) std::copy_n(depth.row(v), depth.width, &depth_[v * depth.width]);
      depth = {depth_.data(), depth.width, depth.height, depth.width};
    }
  }

  static constexpr std::size_t depth_pixels = Sensors::has_depth ? decltype(Sensors::vision)::max_pixels : 0;

  Planned planned_ = Planned::nothing;
  std::optional<On> on_;
  std::optional<View<Sensors>> view_;
  std::array<std::uint16_t, depth_pixels> depth_;
  State previous_state_;  ///< state of the previous frame
  State latest_state_;
  mutable E executor_;  ///< the last member: destroyed first, which ends the task
};

/// Synchronous: no state, no code of a task.
template <class Parts, class MapT>
struct KeyframeTask<Parts, MapT, SynchronousExecutor> {
  using On = Components<Parts, MapT>;
  using Sensors = typename Parts::Sensors;

  static void solve_in_window(const On& on, const View<Sensors>& view, const typename Parts::Motion::State& x) {
    const typename Parts::Motion::State before = on.window.frames().latest();
    const bool keyframe = on.window.insert(view, x, on.motion);
    on.window.solve(view, before, keyframe, on.tracker, on.motion, on.rig_state);
    on.tracker.locate(view, on.window.frames(), on.window.landmarks());
    accept_in_window(on, view);
    if (keyframe) on.window.keep_as_keyframe(view, on.tracker, on.motion, on.navigation);
  }
  static void make_keyframe(const On& on, const View<Sensors>& view) {
    on.window.make_keyframe(view, on.tracker, on.motion, on.rig_state, on.navigation);
  }
  static constexpr bool is_planned() { return false; }
  static void end_frame(const On&, const View<Sensors>&) {}
  static void wait() {}
  static auto latest_state(const auto& window) { return window.latest(); }
};

}  // namespace plumbline
