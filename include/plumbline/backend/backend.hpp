#pragma once
/// A backend estimates the frames that it is given, and the landmarks they see. It owns their states (FrameWindow).
///
///   start     forgets everything; one frame at a place that defines the world
///   restart   the same frames in another world, or another unit, and from now on their links hold
///   insert    one more frame, with its link to an earlier one
///   drop      takes a frame out again, without a trace
///   optimize  frames and landmarks, together
///   retire    turns the frame that leaves into what it leaves behind, and hands it to the map

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/readout_slopes.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class B>
concept HasFrames = requires(const B& backend) {
  typename B::Window;
  typename B::State;
  typename B::Options;
  {backend.window().T_world_body(0)};
  { backend.window().latest() } -> std::convertible_to<typename B::State>;
};

template <class B>
concept Backend = HasFrames<B> &&
    requires(B& backend, const B& known, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, const typename B::State& x, const typename B::Link& link,
             TimeNs t_ns, Mat<typename B::S, state::Pose::dim, state::Pose::dim>& covariance) {
  { backend.start(t_ns, x) } -> std::same_as<int>;
  { backend.insert(t_ns, x, link) } -> std::same_as<int>;
  backend.drop(landmarks, 0);
  backend.optimize(rig, T_body_cam, landmarks, true);
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// Whether the covariance of the newest frame goes on after its pose with that of its velocity.
template <class B>
concept TellsVelocity = HasFrames<B> && B::Layout::template has<state::Velocity>&& requires(
    const B& known, Mat<typename B::S, MovingLayout::dim, MovingLayout::dim>& covariance) {
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// Whether it finds out the readout time of a shutter that rolls; with others that stays what it was taken for.
template <class B>
concept FindsReadout = HasFrames<B> &&
    requires(B& backend, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, ReadoutCorrection& found) {
  backend.believe_readout(0.0, 0.0);
  backend.set_readout(0.0);
  { backend.find_readout(rig, T_body_cam, landmarks, found) } -> std::same_as<bool>;
};

}  // namespace plumbline
