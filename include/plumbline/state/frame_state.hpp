#pragma once
/// State of one frame: its blocks by name, each with its first estimate; and the same as plain values, for motion
/// models and residuals.

#include <tuple>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/state/estimated.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

/// The type that holds the plain values of a frame's blocks. A new layout specializes it.
template <class S, class L>
struct FrameValueOf;

/// State of a frame without an IMU.
template <class S>
struct PoseState {
  SE3<S> T_world_body;
};
template <class S>
struct FrameValueOf<S, VisualLayout> {
  using Type = PoseState<S>;
};
template <class S>
struct FrameValueOf<S, InertialLayout> {
  using Type = NavState<S>;
};

template <class S, class L>
using FrameValue = typename FrameValueOf<S, L>::Type;

/// The value of a block, e.g. `value_of<state::Velocity>(x)`.
template <class Block, class X>
auto& value_of(X& x) {
  if constexpr (std::is_same_v<Block, state::Pose>) {
    return x.T_world_body;
  } else if constexpr (std::is_same_v<Block, state::Velocity>) {
    return x.v_world_body;
  } else if constexpr (std::is_same_v<Block, state::GyroBias>) {
    return x.bias_gyro;
  } else {
    static_assert(std::is_same_v<Block, state::AccelBias>, "plumbline: no frame has such a block");
    return x.bias_accel;
  }
}

/// Blocks of layout L with scalar S.
template <class S, class L>
class FrameState;

template <class S, class... Blocks>
class FrameState<S, Layout<Blocks...>> {
 public:
  using Value = FrameValue<S, Layout<Blocks...>>;
  using Step = Vec<S, Layout<Blocks...>::dim>;

  FrameState() = default;
  explicit FrameState(const Value& x) : blocks_(Estimated<Blocks, S>(value_of<Blocks>(x))...) {}

  template <class Block>
  const Estimated<Block, S>& get() const {
    return std::get<Estimated<Block, S>>(blocks_);
  }
  template <class Block>
  Estimated<Block, S>& get() {
    return std::get<Estimated<Block, S>>(blocks_);
  }

  Value value() const {
    Value x;
    ((value_of<Blocks>(x) = get<Blocks>().value()), ...);
    return x;
  }
  Value first_estimate() const {
    Value x;
    ((value_of<Blocks>(x) = get<Blocks>().first_estimate()), ...);
    return x;
  }
  Step correction() const {
    Step e;
    (set_segment(e, Layout<Blocks...>::template offset<Blocks>, get<Blocks>().correction()), ...);
    return e;
  }

  void add(const Step& d) {
    (get<Blocks>().add(segment<Blocks::dim>(d, Layout<Blocks...>::template offset<Blocks>)), ...);
  }
  void fix_first_estimates() { (get<Blocks>().fix_first_estimate(), ...); }

 private:
  std::tuple<Estimated<Blocks, S>...> blocks_;
};

}  // namespace plumbline
