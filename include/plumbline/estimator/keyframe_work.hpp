#pragma once
/// What makes a frame a keyframe: detection, the bundle or window, marginalization. In order it is done before the
/// frame's pose is published. With an executor every frame is solved for as one that is no keyframe, and published;
/// then the work goes on beside the caller, until the next frame waits for it.
///
/// The work owns all of the odometry while it runs. What may be asked for meanwhile is kept here, as values: the
/// estimate as it was published, the state that readings are integrated about, the frame's depth. So a pose depends on
/// frames and readings, and never on when the work was done.

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
class KeyframeWork {
  using Sensors = typename Core::Sensors;
  using S = typename Core::S;
  using State = typename Core::State;

 public:
  KeyframeWork() = default;
  KeyframeWork(const KeyframeWork&) = delete;
  KeyframeWork& operator=(const KeyframeWork&) = delete;
  ~KeyframeWork() { wait(); }

  void solve_in_window(Core& core, const View<Sensors>& view, const State& x) {
    before_ = core.window().latest();
    if (core.enter_window(view, x)) planned_ = Planned::stay_in_window;
    core.solve_in_window(view, before_, /*keyframe=*/false);
    if (planned_ == Planned::nothing) core.locate(view);
    core.publish_in_window(view);
  }
  void make_keyframe(Core&, const View<Sensors>&) { planned_ = Planned::make_keyframe; }

  /// All that the frame's pose depends on is done.
  void end_frame(Core& core, const View<Sensors>& view) {
    latest_ = core.estimate;
    latest_state_ = core.window().latest();
    if (planned_ == Planned::nothing) return;
    latest_.keyframe = true;
    core_ = &core;
    view_.emplace(view);
    keep_depth();
    executor_.start([](void* self) { static_cast<KeyframeWork*>(self)->run(); }, this);
  }
  void wait() const { executor_.wait(); }

  const Estimate<S>& latest(const Core&) const { return latest_; }
  const State& latest_state(const Core&) const { return latest_state_; }

 private:
  enum class Planned : std::uint8_t { nothing, make_keyframe, stay_in_window };

  void run() {
    if (planned_ == Planned::make_keyframe) {
      core_->make_keyframe(*view_);
    } else {
      core_->solve_in_window(*view_, before_, /*keyframe=*/true);
      core_->locate(*view_);
      core_->stay_in_window(*view_);
    }
    planned_ = Planned::nothing;
  }

  /// The caller's pixels are the caller's again.
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
  State before_;  ///< of the frame before
  Estimate<S> latest_;
  State latest_state_;
  mutable E executor_;  ///< the last: it ends first
};

/// All in order: no state, no code.
template <class Core>
struct KeyframeWork<Core, InOrder> {
  using Sensors = typename Core::Sensors;

  static void solve_in_window(Core& core, const View<Sensors>& view, const typename Core::State& x) {
    const typename Core::State before = core.window().latest();
    const bool keyframe = core.enter_window(view, x);
    core.solve_in_window(view, before, keyframe);
    core.locate(view);
    core.publish_in_window(view);
    if (keyframe) core.stay_in_window(view);
  }
  static void make_keyframe(Core& core, const View<Sensors>& view) { core.make_keyframe(view); }
  static void end_frame(Core&, const View<Sensors>&) {}
  static void wait() {}
  static const auto& latest(const Core& core) { return core.estimate; }
  static auto latest_state(const Core& core) { return core.window().latest(); }
};

}  // namespace plumbline
