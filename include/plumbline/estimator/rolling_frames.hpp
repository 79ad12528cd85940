#pragma once
/// What a rolling shutter asks of an odometry; nothing where all rows are read at once.  docs/math/rolling_shutter.md

#include "plumbline/backend/backend.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/readout_slopes.hpp"
#include "plumbline/feature/row_motion.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Before the backend starts.
template <class Odometry>
void begin_readout(Odometry& odometry) {
  if constexpr (FindsReadout<typename Odometry::Backend>) {
    const auto& rig = odometry.rig_state;
    odometry.backend.believe_readout(double(rig.found_readout_s()), double(rig.readout().sigma_s));
    odometry.backend.set_readout(double(odometry.readout_s()));
  }
}

/// The frame's shutter moves as a body in the state x.
template <class Odometry>
void move_shutter(const Odometry& odometry, View<typename Odometry::Sensors>& view, const typename Odometry::State& x) {
  if constexpr (Odometry::Sensors::rolls) {
    view.set_motion(odometry.motion.angular_rate(), odometry.motion.velocity(x), odometry.mean_depth());
  }
}

/// Of a velocity that images alone tell: the frame's, expected at x, now that the body is at T.
template <class Odometry, class S = typename Odometry::S>
void know_motion(Odometry& odometry, View<typename Odometry::Sensors>& view, const typename Odometry::State& x,
                 const SE3<typename Odometry::S>& T) {
  if constexpr (Odometry::Sensors::rolls && requires { odometry.motion.motion_at(x, T, view); }) {
    if (odometry.motion.ties_frames() || odometry.is_after_gap(view.t_ns)) return;
    const Vec<S, 6> moved = odometry.motion.motion_at(x, T, view);
    view.set_motion(segment<3>(moved, 0), segment<3>(moved, 3), odometry.mean_depth());
    set_motion(odometry.landmarks, view, odometry.readout_s());
  }
}

/// And when the frame before was a keyframe, it is known for good how the camera moved there.
template <class Odometry, class S = typename Odometry::S>
void know_keyframe_motion(Odometry& odometry, const View<typename Odometry::Sensors>& view,
                          const typename Odometry::State& x, const SE3<typename Odometry::S>& T) {
  if constexpr (Odometry::Sensors::rolls && requires { odometry.motion.motion_before(x, T, view); }) {
    if (odometry.motion.ties_frames() || !odometry.estimate.keyframe || odometry.is_after_gap(view.t_ns)) return;
    const Vec<S, 6> moved = odometry.motion.motion_before(x, T, view);
    auto then = view;
    then.set_motion(segment<3>(moved, 0), segment<3>(moved, 3), odometry.mean_depth());
    set_motion(odometry.landmarks, odometry.keyframe(), then, odometry.readout_s());
  }
}

/// What the window says about the readout time after a keyframe, unless it is known; all features move along. Windows
/// overlap: of full ones every third says it all. True when it changed so much that the window is to be solved again.
template <class Odometry, class S = typename Odometry::S>
bool find_readout(Odometry& odometry, const View<typename Odometry::Sensors>& view) {
  if constexpr (FindsReadout<typename Odometry::Backend>) {
    constexpr int in_turn = 3;
    constexpr S much = S(2e-3);
    if (odometry.rig_state.readout().is_known()) return false;
    if (odometry.window().full() && ++odometry.full_windows % in_turn != 0) return false;
    ReadoutCorrection found;
    if (!odometry.backend.find_readout(odometry.rig, view.T_body_cam, odometry.landmarks, found)) return false;
    const S change_s = odometry.rig_state.correct_readout(S(found.value_s), S(found.sigma_s));
    odometry.backend.set_readout(double(odometry.readout_s()));
    odometry.landmarks.for_each([&](auto& store) { store.change_readout(change_s); });
    return change_s > much || -change_s > much;
  }
  return false;
}

}  // namespace plumbline
