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
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/layout.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

/// A backend's types, and access to its frames and to the factors between them.
template <class B>
concept HasFrames = requires(B& backend, const B& known) {
  typename B::State;
  typename B::Factor;
  typename B::Options;  // reached as `options.backend`
  { backend.window() } -> std::same_as<typename B::Window&>;
  { known.window() } -> std::same_as<const typename B::Window&>;
  known.factors();
};

namespace detail {
/// A map that keeps nothing.
struct SomeMap {
  void on_retired(const auto& frame);
};
}  // namespace detail

/// Every call of the estimator to a backend.
template <class B>
concept Backend = HasFrames<B> &&
    requires(B& backend, const B& known, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, const typename B::State& x, const typename B::Factor& factor,
             TimeNs t_ns, Mat<typename B::S, state::Pose::dim, state::Pose::dim>& covariance, detail::SomeMap& map) {
  { backend.start(t_ns, x) } -> std::same_as<int>;
  { backend.insert(t_ns, x, factor) } -> std::same_as<int>;
  backend.drop(landmarks, 0);
  backend.optimize(rig, T_body_cam, landmarks);
  backend.optimize(rig, T_body_cam, landmarks, true);
  known.retired(0, landmarks);
  backend.retire(rig, T_body_cam, landmarks, 0, map);
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// For a camera without depth: fixes the unit of length by the distance of two frames.
template <class B>
concept HoldsScale = requires(B& backend) {
  backend.hold_scale(0, 1);
};

/// A backend that gives the joint covariance of pose and velocity of the newest frame.
template <class B>
concept HasVelocityCovariance = HasFrames<B> && B::Layout::template has<state::Velocity>&& requires(
    const B& known, Mat<typename B::S, MovingLayout::dim, MovingLayout::dim>& covariance) {
  { known.covariance_of_newest(covariance) } -> std::same_as<bool>;
};

/// For frames with IMU factors: restarted after the alignment of vision and IMU, from where on it is solved with the
/// velocities. Their covariance is that of the newest frame, or of the newest keyframe.
template <class B>
concept InertialBackend = Backend<B> && std::convertible_to<decltype(B::Options::solver), LevenbergMarquardtOptions> &&
    requires(B& backend, const typename B::Sensors& rig, typename B::Landmarks& landmarks,
             const SE3<typename B::S>& T_body_cam, typename B::State (*state_of)(int),
             const Mat<double, 6, B::Layout::dim>& J_prior, const TimeOffsetEstimate& time_offset,
             const LevenbergMarquardtOptions& solver) {
  backend.restart(state_of, J_prior, T_body_cam, time_offset);
  backend.optimize(rig, T_body_cam, landmarks, solver);
} &&(HasVelocityCovariance<B> ||
     requires(const B& known, Mat<typename B::S, MovingLayout::dim, MovingLayout::dim>& covariance) {
       { known.covariance_of_keyframe(covariance) } -> std::same_as<bool>;
     });

/// The same without depth: the distance of two frames is known with a sigma [m].
template <class B>
concept HoldsDistance = requires(B& backend) {
  backend.hold_distance(0, 1, 1.0, 0.1);
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
