#pragma once
/// A propagation policy predicts the next frame, with a prior of its pose, and gives the factors between the frames of
/// the window. It owns the measurements of the motion sensors since the latest frame.
///
///   calibrate           applies the estimated calibration to the rig (RigState); returns the time offset [s]
///   begin_frame         integrates the measurements up to a frame; the latest state is null before the first frame
///   predict             the state of the frame. `align_motion(guess)` is the rotation of the camera since the previous
///                       image by image alignment; `outage_s` the time since the last usable image
///   passes_gate         whether a pose is near the prediction (RANSAC consensus)
///   contradicts         whether the motion sensors exclude the pose by the features (innovation gate)
///   update              the state that enters the window, from the pose T by the features and its covariance
///   gyro_jump_rotation  bound of the rotation error by a gyroscope bias jump up to this frame [rad]
///   correct             after the window was optimized: whether the velocity is replaced by that of the images
///   mark_lost           the frame has no pose by its images
///   can_propagate       whether the motion can be predicted without images
///   restart             resets the motion; returns the initial state
///   factor              the factor from the last keyframe to the latest frame
///   begin_factor        starts a new factor at the latest frame
///   confirm_keyframe    whether the frame becomes a keyframe, from the mean motion of its landmarks [px] and the rule
///   diagnose            the reason for degraded health, by the motion sensors
///   is_inconsistent     whether images and motion sensors contradict each other, whatever that reason is

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/pose_prior.hpp"

namespace plumbline {

template <class X, class S>
struct Prediction {
  X state;             ///< of the frame
  PosePrior<S> prior;  ///< of its pose
};

/// T, the predicted pose, with the rotation by image alignment where that is valid.
template <class S>
SE3<S> with_image_rotation(const SE3<S>& T, const auto& view, auto&& align_motion) {
  const SE3<S>& T_world_previous = view.T_world_previous;
  const auto aligned = align_motion((T * view.T_body_cam).inverse() * (T_world_previous * view.T_body_cam));
  if (!aligned.valid) return T;
  const SO3<S> R_body_cam = view.T_body_cam.rotation();
  return SE3<S>(T_world_previous.rotation() * R_body_cam * aligned.R_cur_prev.inverse() * R_body_cam.inverse(),
                aligned.moved ? T.p() : T_world_previous.p());
}

/// The prediction. angular_rate [rad/s] and velocity [m/s] are those of the body in this frame, in its own axes.
template <class M>
concept Predicts = requires(M& propagation, const M& known, const typename M::State& x, typename M::S dt) {
  propagation.begin_frame(TimeNs{}, &x, dt);
  { known.angular_rate() } -> std::convertible_to<Vec<typename M::S, 3>>;
  { known.velocity(x) } -> std::convertible_to<Vec<typename M::S, 3>>;
  { known.can_propagate() } -> std::convertible_to<bool>;
  { propagation.restart(x) } -> std::same_as<typename M::State>;
  propagation.mark_lost();
};

/// The factors. `is_initialized`: factors are active, so every frame is solved together with the window.
/// `has_imu_factors`: each factor connects a frame with the previous one in time.
template <class M>
concept ProvidesFactors = requires(M& propagation, const M& known, const typename M::State& x) {
  typename M::Layout;  // state blocks of a frame
  typename M::Factor;
  typename M::template Factors<4>;
  { M::has_imu_factors } -> std::convertible_to<bool>;
  { known.is_initialized() } -> std::convertible_to<bool>;
  { known.is_stationary() } -> std::convertible_to<bool>;
  { known.factor(0) } -> std::same_as<typename M::Factor>;
  propagation.begin_factor(x);
};

template <class M>
concept Propagation = Predicts<M> && ProvidesFactors<M>;

}  // namespace plumbline
