#pragma once
/// A frame has a pose: images, navigation state and report follow. With IMU factors the pose is the solution of the
/// window; without, it is that of the frame alone.

#include "plumbline/core/matrix.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/propagation/propagation.hpp"

namespace plumbline {

/// The latest frame of the window, with IMU factors, has been solved for.
template <class Parts, class MapT>
void accept_in_window(const Components<Parts, MapT>& on, const View<typename Parts::Sensors>& view) {
  on.tracker.images().keep(view, on.window.frames().latest().T_world_body);
  on.window.accept_latest(on.propagation, on.navigation, on.report);
  on.tracker.set_usable(view.t_ns);
  on.window.update_covariance(on.propagation, on.navigation);
}

/// A frame without IMU factors has the state x; `covariance`: of its pose with respect to the last keyframe.
template <class Parts, class MapT>
void accept_alone(const Components<Parts, MapT>& on, const View<typename Parts::Sensors>& view,
                  const typename Parts::Propagation::State& x, const Mat<typename Parts::S, 6, 6>& covariance) {
  on.window.frames().set_latest(x);
  on.tracker.images().keep(view, x.T_world_body);
  on.window.accept_latest(on.propagation, on.navigation, on.report);
  // Covariance of the keyframe, carried to this body by the adjoint, plus that of the motion since.
  on.navigation.set_window_covariance(on.window.covariance_of(x.T_world_body, covariance));
  on.tracker.locate(view, on.window.frames(), on.window.landmarks());
  on.tracker.set_usable(view.t_ns);
}

/// Adds inflation for unmodeled error to the uncertainty of the world frame: the rotation that a gyroscope bias jump
/// may have caused, about any axis since tilt is taken for accelerometer bias; and, while images and IMU disagree, the
/// difference between the solved and the predicted pose when it exceeds the gate.
template <class State, class S>
void inflate_world_frame(const auto& propagation, const FrameReport& report, const Prediction<State, S>& predicted,
                         auto& navigation) {
  const SE3<S>& T = navigation.T_world_body();
  if (propagation.gyro_jump_rotation() > S(0))
    navigation.world().add_rotation_uncertainty(T, propagation.gyro_jump_rotation());
  if (report.is_inconsistent && !propagation.passes_gate(predicted, T))
    navigation.world().inflate(minus(T, predicted.state.T_world_body));
}

}  // namespace plumbline
