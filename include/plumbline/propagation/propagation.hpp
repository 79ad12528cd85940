#pragma once
/// A propagation policy predicts the next frame, with a prior of its pose, and gives the factors between the frames of
/// the window. It owns the measurements of the motion sensors since the latest frame.
///
///   calibrate           applies the estimated calibration to the rig (RigState)
///   begin_frame         integrates the measurements up to a frame; the latest state is null before the first frame
///   T_body_cam          the extrinsics in use
///   predict             the state of the frame. `align_motion(guess)` is the rotation of the camera since the previous
///                       image by image alignment; `outage_s` the time since the last usable image
///   passes_gate         whether a pose is near the prediction (RANSAC consensus)
///   contradicts         whether the motion sensors exclude the pose by the features (innovation gate)
///   update              the state that enters the window, from the pose T by the features and its covariance
///   gyro_jump_rotation  bound of the rotation error by a gyroscope bias jump up to this frame [rad]
///   correct             after the window was optimized: whether the velocity is replaced by that of the images
///   mark_lost           the frame has no pose by its images
///   can_propagate       whether the motion can be predicted without images
///   grown_covariance    covariance of a pose after one more frame without images
///   restart             resets the motion; returns the initial state
///   factor              the factor from the last keyframe to the latest frame
///   begin_factor        starts a new factor at the latest frame
///   is_stationary       whether the body is at rest, by the last confirm_keyframe or detect_stationarity
///   can_be_stationary   whether the motion sensors do not exclude it
///   confirm_keyframe    whether the frame becomes a keyframe, from the mean motion of its landmarks [px] and the rule
///   diagnose            the reason for degraded health, by the motion sensors
///   is_inconsistent     whether images and motion sensors contradict each other, whatever that reason is

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/layout.hpp"
#include "plumbline/state/pose_prior.hpp"
#include "plumbline/state/rig_state.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

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

/// The types, and the constructor. `has_imu_factors`: each factor connects a frame with the previous one in time.
template <class P>
concept HasFrameTypes = requires {
  typename P::State;    // values of a frame
  typename P::Layout;   // state blocks of a frame
  typename P::Factor;   // ties a frame to an earlier one
  typename P::Options;  // reached as `options.propagation`
  typename P::template Factors<4>;
  { P::has_imu_factors } -> std::convertible_to<bool>;
}
&&SensorRig<typename P::Sensors>&& std::constructible_from<P, const typename P::Sensors&, const typename P::Options&>;

namespace detail {
/// What the concepts are checked with: some window of frames, and an image alignment.
template <class P>
using SomeWindow = FrameWindow<typename P::S, typename P::Layout, 4>;
template <class S>
struct SomeAlignment {
  struct Aligned {
    bool valid, moved;
    SO3<S> R_cur_prev;
  };
  Aligned operator()(const SE3<S>& guess) const;
};
}  // namespace detail

/// The prediction.
template <class P>
concept Predicts = HasFrameTypes<P> &&
    requires(P& propagation, const P& known, const typename P::State& x, const SE3<typename P::S>& T,
             typename P::S seconds, const View<typename P::Sensors>& view, RigState<typename P::Sensors>& rig_state,
             const detail::SomeWindow<P>& window, const detail::SomeAlignment<typename P::S>& align_motion,
             const Mat<typename P::S, 6, 6>& covariance) {
  propagation.calibrate(rig_state, window);
  propagation.begin_frame(TimeNs{}, &x, seconds);
  { known.T_body_cam(T) } -> std::convertible_to<SE3<typename P::S>>;
  { propagation.predict(x, view, seconds, align_motion) } -> std::same_as<Prediction<typename P::State, typename P::S>>;
  { known.can_propagate() } -> std::convertible_to<bool>;
  { known.grown_covariance(covariance, seconds) } -> std::convertible_to<Mat<typename P::S, 6, 6>>;
  { propagation.restart(x) } -> std::same_as<typename P::State>;
  propagation.mark_lost();
};

/// What the motion sensors say of a pose by images.
template <class P>
concept ChecksPoses = HasFrameTypes<P> &&
    requires(P& propagation, const P& known, const typename P::State& x, typename P::State& solved,
             const SE3<typename P::S>& T, typename P::S seconds, const View<typename P::Sensors>& view,
             const Prediction<typename P::State, typename P::S>& predicted, const detail::SomeWindow<P>& window,
             const typename P::template Factors<4>& factors, const Mat<typename P::S, 6, 6>& covariance) {
  { known.passes_gate(predicted, T) } -> std::convertible_to<bool>;
  { known.contradicts(predicted, T) } -> std::convertible_to<bool>;
  { propagation.update(x, T, covariance, view) } -> std::same_as<typename P::State>;
  { known.correct(x, solved, seconds) } -> std::convertible_to<bool>;
  { known.gyro_jump_rotation() } -> std::convertible_to<typename P::S>;
  { propagation.diagnose(factors, window, true) } -> std::same_as<HealthReason>;
  { known.is_inconsistent() } -> std::convertible_to<bool>;
};

/// The factors. `is_initialized`: factors are active, so every frame is solved together with the window.
template <class P>
concept ProvidesFactors = HasFrameTypes<P> &&
    requires(P& propagation, const P& known, TimeNs t_ns, double (*motion_px)()) {
  { known.is_initialized() } -> std::convertible_to<bool>;
  { known.is_stationary() } -> std::convertible_to<bool>;
  { propagation.can_be_stationary(t_ns) } -> std::convertible_to<bool>;
  { propagation.confirm_keyframe(t_ns, motion_px, true) } -> std::convertible_to<bool>;
  { known.factor(0) } -> std::same_as<typename P::Factor>;
  propagation.begin_factor();
};

/// For a rolling shutter: angular rate [rad/s] and velocity [m/s] of the body in this frame, in its own axes. Two more
/// members are optional, for velocities that images alone determine: motion_at, motion_before (Inertial).
template <class P>
concept PredictsShutterMotion = requires(const P& known, const typename P::State& x) {
  { known.angular_rate() } -> std::convertible_to<Vec<typename P::S, 3>>;
  { known.velocity(x) } -> std::convertible_to<Vec<typename P::S, 3>>;
};

/// Without depth: whether the body is at rest while a second view is awaited.
template <class P>
concept DetectsStationarity = requires(P& propagation, TimeNs t_ns, double motion_px) {
  { propagation.detect_stationarity(t_ns, motion_px) } -> std::convertible_to<bool>;
};

/// With an IMU: its samples, what initialization determines, and what the window knows of the velocity. The options
/// have gravity, velocity_sigma and stationary_position_sigma (InertialOptions).
template <class P>
concept PropagatesByImu = requires(P& propagation, const P& known, const detail::SomeWindow<P>& window,
                                   const Vec<typename P::S, 3>& v,
                                   const Mat<typename P::S, MovingLayout::dim, MovingLayout::dim>& covariance) {
  { propagation.imu() } -> std::same_as<ImuIntegrator<typename P::S>&>;
  { known.imu() } -> std::same_as<const ImuIntegrator<typename P::S>&>;
  { known.camera_imu() } -> std::same_as<const CameraImuFilter&>;
  { known.options() } -> std::same_as<const typename P::Options&>;
  { known.stationary_state() } -> std::same_as<typename P::State>;
  { known.time_offset(1e-3) } -> std::same_as<TimeOffsetEstimate>;
  propagation.adopt_time_offset(window);
  propagation.set_initialized();
  propagation.set_velocity_covariance(covariance);
  propagation.set_speed_covariance(covariance, v);
  { known.speed() } -> std::convertible_to<double>;
  { known.speed_sigma() } -> std::convertible_to<double>;
};

/// Every call of estimator and backend that the sensors of the policy give rise to.
template <class P>
concept Propagation = Predicts<P> && ChecksPoses<P> && ProvidesFactors<P> &&
    (!P::Sensors::rolls || PredictsShutterMotion<P>)&&(P::Sensors::has_depth ||
                                                       DetectsStationarity<P>)&&(!P::Sensors::has_imu ||
                                                                                 PropagatesByImu<P>);

}  // namespace plumbline
