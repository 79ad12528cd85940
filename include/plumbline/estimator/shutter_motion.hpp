#pragma once
/// Correction of a rolling shutter in the estimator; empty for a global shutter.  docs/math/rolling_shutter.md

#include "plumbline/backend/backend.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/row_motion.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// Sets the motion during the readout of the frame to that of the body in the state x; landmarks without depth are
/// taken at the distance `range` [m].
template <SensorRig Sensors>
void set_shutter_motion(View<Sensors>& view, const auto& propagation, const auto& x, typename Sensors::Scalar range) {
  if constexpr (Sensors::rolls) view.set_motion(propagation.angular_rate(), propagation.velocity(x), range);
}

/// Sets the motion of a frame whose velocity is determined by images alone: x is its predicted state, T its pose now.
template <SensorRig Sensors, class S = typename Sensors::Scalar>
void update_frame_motion(View<Sensors>& view, const auto& propagation, auto& landmarks, const auto& x,
                         const SE3<typename Sensors::Scalar>& T, typename Sensors::Scalar readout_s) {
  if constexpr (Sensors::rolls && requires { propagation.motion_at(x, T, view); }) {
    const Vec<S, 6> twist = propagation.motion_at(x, T, view);
    view.set_motion(segment<3>(twist, 0), segment<3>(twist, 3), landmarks.template mean_depth<S>());
    set_motion(landmarks, view, readout_s);
  }
}

/// Sets the motion of a keyframe, when the frame after it is known. T is the pose of that frame, x its prediction.
///                                                                          docs/math/rolling_shutter.md (1c)
template <SensorRig Sensors, class S = typename Sensors::Scalar>
void update_keyframe_motion(const View<Sensors>& view, const auto& propagation, auto& landmarks, int keyframe,
                            const auto& x, const SE3<typename Sensors::Scalar>& T, typename Sensors::Scalar readout_s) {
  if constexpr (Sensors::rolls && requires { propagation.motion_before(x, T, view); }) {
    const Vec<S, 6> twist = propagation.motion_before(x, T, view);
    View<Sensors> keyframe_view = view;
    keyframe_view.set_motion(segment<3>(twist, 0), segment<3>(twist, 3), landmarks.template mean_depth<S>());
    set_motion(landmarks, keyframe, keyframe_view, readout_s);
  }
}

/// Estimation of the readout time by the window.
template <class Backend>
class ReadoutEstimation {
 public:
  using S = typename Backend::S;

  /// Sets the prior of the readout time, before the backend starts.
  static void start(Backend& backend, const auto& rig_state) {
    if constexpr (EstimatesReadout<Backend>) {
      backend.set_readout_prior(double(rig_state.found_readout_s()), double(rig_state.readout().sigma_s));
      backend.set_readout(double(rig_state.readout().value_s));
    }
  }

  /// Estimates the readout time from the window after a keyframe, unless it is calibrated; all features are corrected
  /// for its change. Full windows overlap, so only every third one is used. True when the change exceeds 2 ms, after
  /// which the window is to be optimized again.
  bool update(Backend& backend, const auto& view, auto& landmarks, auto& rig_state) {
    if constexpr (EstimatesReadout<Backend>) {
      constexpr int solved_every = 3;      // tuned: docs/decisions/036
      constexpr S min_change_s = S(2e-3);  // tuned: docs/decisions/133 (chosen)
      if (rig_state.readout().is_known()) return false;
      if (backend.window().full() && ++full_windows_ % solved_every != 0) return false;
      ReadoutCorrection found;
      if (!backend.find_readout(view.rig, view.T_body_cam, landmarks, found)) return false;
      const S change_s = rig_state.correct_readout(S(found.value_s), S(found.sigma_s));
      backend.set_readout(double(rig_state.readout().value_s));
      landmarks.for_each([&](auto& store) { store.change_readout(change_s); });
      return change_s > min_change_s || -change_s > min_change_s;
    }
    return false;
  }

 private:
  int full_windows_ = 0;  ///< number of full windows that were solved
};

}  // namespace plumbline
