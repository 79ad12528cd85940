#pragma once
/// A motion model says where the next frame is expected and how sure that is, and ties the frames of the window
/// together by links. It owns what the sensors of the motion have told since the latest frame.
///
///   calibrate         corrects what is believed of the rig (RigState) by what was found out about it; returns the time
///                     offset of the camera [s]
///   begin_frame       takes in what was measured up to a frame; the latest state is null before the first one
///   predict           the frame's state, before its features are used. `align_motion(guess)` is what the images say of
///                     the camera's motion since the previous one; `blind_s`: since when images are of no use
///   admits            whether a pose is as near to the prediction as it should be
///   contradicts       whether the sensors of the motion exclude the pose that the frame's features say
///   update            the frame's features say that it is at T, that well: the state with which it enters the window
///   turned_wrongly    by how much readings that were found wrong may have turned the frames up to this one [rad]
///   revise            after the window was solved: whether the frame's state is corrected by what the images alone say
///   lose              the images do not say where the frame is; `carries_on` if the model can without them
///   restart           everything begins anew; returns where
///   link, begin_link  from the last keyframe on; `at_rest`: the body has not moved since
///   confirm_keyframe  whether a frame becomes a keyframe: by how far most landmarks moved [px], if the rule wants it
///   doubt             what is wrong with what the sensors say

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
  PosePrior<S> prior;  ///< about its pose
};

/// T, where the body is expected, with the camera's rotation as the images show it.
template <class S>
SE3<S> turned_as_seen(const SE3<S>& T, const auto& view, auto&& align_motion) {
  const SE3<S>& T_world_previous = view.T_world_previous;
  const auto seen = align_motion((T * view.T_body_cam).inverse() * (T_world_previous * view.T_body_cam));
  if (!seen.valid) return T;
  const SO3<S> R_body_cam = view.T_body_cam.rotation();
  return SE3<S>(T_world_previous.rotation() * R_body_cam * seen.R_cur_prev.inverse() * R_body_cam.inverse(),
                seen.moved ? T.p() : T_world_previous.p());
}

template <class M>
concept Predicts = requires(M& motion, const M& known, const typename M::State& x, typename M::S dt) {
  motion.begin_frame(TimeNs{}, &x, dt);
  { known.angular_rate() } -> std::convertible_to<Vec<typename M::S, 3>>;  // of the body in this frame [rad/s]
  { known.velocity(x) } -> std::convertible_to<Vec<typename M::S, 3>>;     // there, in the body's own axes [m/s]
  { known.carries_on() } -> std::convertible_to<bool>;
  { motion.restart(x) } -> std::same_as<typename M::State>;
  motion.lose();
};

/// `ties_frames`: links hold, so that every frame is solved for together with the window. `is_chain`: they go from each
/// frame to the one before it.
template <class M>
concept Ties = requires(M& motion, const M& known, const typename M::State& x) {
  typename M::Layout;  // blocks of a frame
  typename M::Link;
  typename M::template Links<4>;
  { M::is_chain } -> std::convertible_to<bool>;
  { known.ties_frames() } -> std::convertible_to<bool>;
  { known.at_rest() } -> std::convertible_to<bool>;
  { known.link(0) } -> std::same_as<typename M::Link>;
  motion.begin_link(x);
};

template <class M>
concept MotionModel = Predicts<M> && Ties<M>;

}  // namespace plumbline
