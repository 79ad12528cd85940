#pragma once
/// Tracks of the corners of a first view, while a second view is awaited: each frame gives their pairs of bearings to
/// the initializer.

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Follows the corners into the frame, whose rotation is predicted and whose position is that of the first view; sets
/// the latest state of the window to the returned one, and `initializer` to the pairs that are left.
template <class Sensors, class State>
State follow_first_view(const View<Sensors>& view, const State& predicted, auto& initializer, auto&& on) {
  using S = typename Sensors::Scalar;
  auto& frames = on.window.frames();
  auto& landmarks = on.window.landmarks();
  State x = predicted;
  x.T_world_body = SE3<S>(predicted.T_world_body.rotation(), frames.T_world_body(on.window.keyframe()).p());
  on.tracker.front_ends().follow(view, frames, landmarks, x.T_world_body);
  frames.set_latest(x);
  on.tracker.images().keep(view, x.T_world_body);
  on.tracker.set_usable(view.t_ns);
  initializer.clear_pairs();
  on.tracker.front_ends().for_each_pair(
      view, landmarks, on.window.keyframe(),
      [&](const Vec<S, 3>& f1, const Vec<S, 3>& f2) { initializer.add_pair(f1, f2); });
  landmarks.for_each([](auto& store) { store.prune(); });
  return x;
}

/// Rotation from the camera of the first view to that of the frame in state x.
template <class S>
SO3<S> rotation_since_first_view(const SE3<S>& T_world_first, const SE3<S>& T_world_body, const SE3<S>& T_body_cam) {
  const SO3<S> R_world_first = T_world_first.rotation() * T_body_cam.rotation();
  return (T_world_body.rotation() * T_body_cam.rotation()).inverse() * R_world_first;
}

}  // namespace plumbline
