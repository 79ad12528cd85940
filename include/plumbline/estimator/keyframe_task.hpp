#pragma once
/// The keyframe task: detection, window optimization and marginalization, which make a frame a keyframe. With
/// SynchronousExecutor it is done before the frame's pose is published. With another executor each frame is solved for
/// as one that is no keyframe, and published; the task then runs beside the caller, and the next frame waits for it.
///
/// The task has exclusive access to the odometry while it runs. What can be asked for meanwhile is copied here: the
/// published estimate, the state about which IMU samples are integrated, the frame's depth image. So estimates depend
/// on frames and IMU samples, and not on the time at which the task runs.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

template <class Core, Executor E>
class KeyframeTask {
  using Sensors = typename Core::Sensors;
  using S = typename Core::S;
  using State = typename Core::State;

 public:
  KeyframeTask() = default;
  KeyframeTask(const KeyframeTask&) = delete;
  KeyframeTask& operator=(const KeyframeTask&) = delete;
  ~KeyframeTask() { wait(); }

  void solve_in_window(Core& core, const View<Sensors>& view, const State& x) {
    previous_state_ = core.window().latest();
    if (core.insert_into_window(view, x)) planned_ = Planned::keep_as_keyframe;
    core.solve_in_window(view, previous_state_, /*keyframe=*/false);
    if (planned_ == Planned::nothing) core.locate(view);
    core.publish_in_window(view);
  }
  void make_keyframe(Core&, const View<Sensors>&) { planned_ = Planned::make_keyframe; }

  /// Starts the task, if there is one. The pose of the frame is final.
  void end_frame(Core& core, const View<Sensors>& view) {
    latest_ = core.estimate;
    latest_state_ = core.window().latest();
    if (planned_ == Planned::nothing) return;
    latest_.keyframe = true;
    core_ = &core;
    view_.emplace(view);
    keep_depth();
    executor_.start([](void* self) { static_cast<KeyframeTask*>(self)->run(); }, this);
  }
  void wait() const { executor_.wait(); }

  const Estimate<S>& latest(const Core&) const { return latest_; }
  const State& latest_state(const Core&) const { return latest_state_; }

 private:
  enum class Planned : std::uint8_t { nothing, make_keyframe, keep_as_keyframe };

  void run() {
    if (planned_ == Planned::make_keyframe) {
      core_->make_keyframe(*view_);
    } else {
      core_->solve_in_window(*view_, previous_state_, /*keyframe=*/true);
      core_->locate(*view_);
      core_->keep_as_keyframe(*view_);
    }
    planned_ = Planned::nothing;
  }

  /// Copies the depth image, because the caller's pixels are not valid after add_frame.
  void keep_depth() {
    if constexpr (Sensors::has_depth) {
      auto& depth = view_->depth;
      if (depth.empty()) return;
      for (int v = 0; v < depth.height; ++v) std::copy_n(depth.row(v), depth.width, &depth_[v * depth.width]);
      depth = {depth_.data(), depth.width, depth.height, depth.width};
    }
  }

  static constexpr std::size_t depth_pixels = Sensors::has_depth ? decltype(Sensors::vision)::max_pixels : 0;

  Planned planned_ = Planned::nothing;
  Core* core_ = nullptr;
  std::optional<View<Sensors>> view_;
  std::array<std::uint16_t, depth_pixels> depth_;
  State previous_state_;  ///< of the previous frame
  Estimate<S> latest_;
  State latest_state_;
  mutable E executor_;  ///< the last member: destroyed first
};

/// The synchronous form: no state, no copies.
template <class Core>
struct KeyframeTask<Core, SynchronousExecutor> {
  using Sensors = typename Core::Sensors;

  static void solve_in_window(Core& core, const View<Sensors>& view, const typename Core::State& x) {
    const typename Core::State before = core.window().latest();
    const bool keyframe = core.insert_into_window(view, x);
    core.solve_in_window(view, before, keyframe);
    core.locate(view);
    core.publish_in_window(view);
    if (keyframe) core.keep_as_keyframe(view);
  }
  static void make_keyframe(Core& core, const View<Sensors>& view) { core.make_keyframe(view); }
  static void end_frame(Core&, const View<Sensors>&) {}
  static void wait() {}
  static const auto& latest(const Core& core) { return core.estimate; }
  static auto latest_state(const Core& core) { return core.window().latest(); }
};

}  // namespace plumbline
