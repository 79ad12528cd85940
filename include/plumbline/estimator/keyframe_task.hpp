#pragma once
/// The keyframe task: detection, window optimization and marginalization, which make a frame a keyframe. Every frame is
/// solved for as one that is no keyframe, and published; then the task runs, with SynchronousExecutor before add_frame
/// returns, with another executor beside the caller, and the next frame waits for it. So every executor gives the same
/// estimates, bit for bit.
///
/// The task has exclusive access to the components while it runs. What can be asked for meanwhile is copied: the
/// published estimate (Publisher), and here the state about which IMU samples are integrated and the frame's depth
/// image.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "plumbline/estimator/accept_pose.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

template <class Parts, class MapT, Executor E>
class KeyframeTask {
  using On = Components<Parts, MapT>;
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using State = typename Parts::Propagation::State;

 public:
  /// Inserts a frame with IMU factors in the state x into the window and solves for it.
  void solve_in_window(const On& on, const View<Sensors>& view, const State& x) {
    previous_state_ = on.window.frames().latest();
    if (on.window.insert(view, x, on.propagation)) planned_ = Planned::keep_as_keyframe;
    on.window.solve(view, previous_state_, /*keyframe=*/false, on.tracker, on.propagation, on.rig_state);
    if (planned_ == Planned::nothing) on.tracker.locate(view, on.window.frames(), on.window.landmarks());
    accept_in_window(on, view);
  }
  /// Accepts the pose of a frame without IMU factors. It becomes a keyframe where one is needed, and at once where the
  /// initialization is to align vision and IMU.
  void accept_alone(const On& on, const View<Sensors>& view, const State& x, const Mat<S, 6, 6>& covariance,
                    auto& initialization) {
    plumbline::accept_alone(on, view, x, covariance);
    const bool ready_to_align = initialization.add_pose(view, covariance, on),
               needed = on.window.needs_keyframe(view, on.propagation);
    if (ready_to_align) {
      on.window.make_keyframe(view, on.tracker, on.propagation, on.rig_state, on.navigation);
      initialization.align(view, on);
    } else if (needed) {
      planned_ = Planned::make_keyframe;
    }
  }

  /// Whether the frame becomes a keyframe after it is published.
  bool is_planned() const { return planned_ != Planned::nothing; }
  /// Starts the task, if there is one. The frame has been published.
  void end_frame(const On& on, const View<Sensors>& view) {
    latest_state_ = on.window.frames().latest();
    if (!is_planned()) return;
    if constexpr (is_synchronous) {
      run(on, view);
    } else {
      on_.emplace(on);
      view_.emplace(view);
      copy_depth();
      executor_.start([](void* self) { static_cast<KeyframeTask*>(self)->run(); }, this);
    }
  }
  void wait() const { executor_.wait(); }
  E& executor() { return executor_; }

  const State& latest_state() const { return latest_state_; }

 private:
  enum class Planned : std::uint8_t { nothing, make_keyframe, keep_as_keyframe };

  void run() { run(*on_, *view_); }
  void run(const On& on, const View<Sensors>& view) {
    if (planned_ == Planned::make_keyframe) {
      on.window.make_keyframe(view, on.tracker, on.propagation, on.rig_state, on.navigation);
    } else {
      on.window.solve(view, previous_state_, /*keyframe=*/true, on.tracker, on.propagation, on.rig_state);
      on.tracker.locate(view, on.window.frames(), on.window.landmarks());
      on.window.keep_as_keyframe(view, on.tracker, on.propagation, on.navigation);
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

  static constexpr bool is_synchronous = std::is_same_v<E, SynchronousExecutor>;
  static constexpr std::size_t depth_pixels =
      Sensors::has_depth && !is_synchronous ? decltype(Sensors::vision)::max_pixels : 0;
  template <class T>
  struct Nothing {};
  template <class T>
  using Kept = std::conditional_t<is_synchronous, Nothing<T>, std::optional<T>>;

  Planned planned_ = Planned::nothing;
  [[no_unique_address]] Kept<On> on_;
  [[no_unique_address]] Kept<View<Sensors>> view_;
  [[no_unique_address]] std::array<std::uint16_t, depth_pixels> depth_;
  State previous_state_;  ///< state of the previous frame
  State latest_state_;
  [[no_unique_address]] mutable E executor_;  ///< the last member: destroyed first, which ends the task
};

}  // namespace plumbline
