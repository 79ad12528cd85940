#pragma once
/// Concept of a backend: it estimates the frames that it is given and the landmarks that they observe, and owns their
/// states (FrameWindow).
///
///   start     clears everything; one frame whose pose defines the world
///   restart   the same frames with new states (another world or unit); from then on their factors are active
///   insert    one more frame, with its factor to an earlier one
///   drop      removes a frame without leaving information
///   optimize  joint solution for frames and landmarks
///   retired   a frame as it is handed to the map (map/retired.hpp)
///   retire    turns a frame that leaves into prior information, and hands it to the map

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

/// A backend's types, and read access to its frames.
template <class B>
concept HasFrames = requires(const B& backend) {
  typename B::Window;
  typename B::State;
  typename B::Options;
  {backend.window().T_world_body(0)};
  { backend.window().latest() } -> std::convertible_to<typename B::State>;
};

/// Every call of the estimator to a backend.
template <class B>
concept Backend = HasFrames<B> &&
    requires(B& backend, const B& known, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, const typename B::State& x, const typename B::Factor& factor,
             TimeNs t_ns, Mat<typename B::S, state::Pose::dim, state::Pose::dim>& covariance) {
  { backend.start(t_ns, x) } -> std::same_as<int>;
  { backend.insert(t_ns, x, factor) } -> std::same_as<int>;
  backend.drop(landmarks, 0);
  backend.optimize(rig, T_body_cam, landmarks, true);
  known.retired(0, landmarks);
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// A backend that gives the joint covariance of pose and velocity of the newest frame.
template <class B>
concept HasVelocityCovariance = HasFrames<B> && B::Layout::template has<state::Velocity>&& requires(
    const B& known, Mat<typename B::S, MovingLayout::dim, MovingLayout::dim>& covariance) {
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// A backend to whose frames factors of type G can be attached; false when this one is refused.
template <class B, class G>
concept TakesFactor = HasFrames<B> && requires(B& backend, const G& factor) {
  { backend.add_factor(0, factor) } -> std::same_as<bool>;
};

/// A backend that estimates the readout time of a rolling shutter; with others it keeps its calibrated value.
template <class B>
concept EstimatesReadout = HasFrames<B> &&
    requires(B& backend, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, ReadoutCorrection& found) {
  backend.set_readout_prior(0.0, 0.0);
  backend.set_readout(0.0);
  { backend.find_readout(rig, T_body_cam, landmarks, found) } -> std::same_as<bool>;
};

}  // namespace plumbline
