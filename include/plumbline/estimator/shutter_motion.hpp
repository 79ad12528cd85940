#pragma once
/// Correction of a rolling shutter in the odometry; empty for a global shutter.  docs/math/rolling_shutter.md

#include "plumbline/backend/backend.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/row_motion.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Sets the prior of the readout time, before the backend starts.
template <class Odometry>
void start_readout(Odometry& odometry) {
  if constexpr (EstimatesReadout<typename Odometry::Backend>) {
    const auto& rig = odometry.rig_state;
    odometry.backend.set_readout_prior(double(rig.found_readout_s()), double(rig.readout().sigma_s));
    odometry.backend.set_readout(double(odometry.readout_s()));
  }
}

/// Sets the motion during the readout of the frame to that of the body in the state x.
template <class Odometry>
void set_shutter_motion(const Odometry& odometry, View<typename Odometry::Sensors>& view,
                        const typename Odometry::State& x) {
  if constexpr (Odometry::Sensors::rolls) {
    view.set_motion(odometry.motion.angular_rate(), odometry.motion.velocity(x), odometry.mean_depth());
  }
}

/// Sets the motion of a frame whose velocity is determined by images alone: x is its predicted state, T its pose now.
template <class Odometry, class S = typename Odometry::S>
void update_frame_motion(Odometry& odometry, View<typename Odometry::Sensors>& view, const typename Odometry::State& x,
                         const SE3<typename Odometry::S>& T) {
  if constexpr (Odometry::Sensors::rolls && requires { odometry.motion.motion_at(x, T, view); }) {
    if (odometry.motion.is_initialized() || odometry.is_after_gap(view.t_ns)) return;
    const Vec<S, 6> twist = odometry.motion.motion_at(x, T, view);
    view.set_motion(segment<3>(twist, 0), segment<3>(twist, 3), odometry.mean_depth());
    set_motion(odometry.landmarks, view, odometry.readout_s());
  }
}

/// Sets the motion of a keyframe, when the frame after it is known. T is the pose of that frame, x its prediction.
///                                                                          docs/math/rolling_shutter.md (1c)
template <class Odometry, class S = typename Odometry::S>
void update_keyframe_motion(Odometry& odometry, const View<typename Odometry::Sensors>& view,
                            const typename Odometry::State& x, const SE3<typename Odometry::S>& T) {
  if constexpr (Odometry::Sensors::rolls && requires { odometry.motion.motion_before(x, T, view); }) {
    if (odometry.motion.is_initialized() || !odometry.estimate.keyframe || odometry.is_after_gap(view.t_ns)) return;
    const Vec<S, 6> twist = odometry.motion.motion_before(x, T, view);
    auto keyframe_view = view;
    keyframe_view.set_motion(segment<3>(twist, 0), segment<3>(twist, 3), odometry.mean_depth());
    set_motion(odometry.landmarks, odometry.keyframe(), keyframe_view, odometry.readout_s());
  }
}

/// Estimates the readout time from the window after a keyframe, unless it is calibrated; all features are corrected for
/// its change. Full windows overlap, so only every third one is used. True when the change exceeds 2 ms, after which
/// the window is to be optimized again.
template <class Odometry, class S = typename Odometry::S>
bool find_readout(Odometry& odometry, const View<typename Odometry::Sensors>& view) {
  if constexpr (EstimatesReadout<typename Odometry::Backend>) {
    constexpr int solved_every = 3;
    constexpr S min_change_s = S(2e-3);
    if (odometry.rig_state.readout().is_known()) return false;
    if (odometry.window().full() && ++odometry.full_windows % solved_every != 0) return false;
    ReadoutCorrection found;
    if (!odometry.backend.find_readout(odometry.rig, view.T_body_cam, odometry.landmarks, found)) return false;
    const S change_s = odometry.rig_state.correct_readout(S(found.value_s), S(found.sigma_s));
    odometry.backend.set_readout(double(odometry.readout_s()));
    odometry.landmarks.for_each([&](auto& store) { store.change_readout(change_s); });
    return change_s > min_change_s || -change_s > min_change_s;
  }
  return false;
}

}  // namespace plumbline
