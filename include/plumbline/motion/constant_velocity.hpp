#pragma once
/// Motion of a camera alone: constant velocity, its rotation replaced by what the images say where they say it clearly,
/// its translation left out where they fit better without. It predicts; it ties no frames together.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/motion/motion_model.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_state.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

struct ConstantVelocityOptions {
  double max_prediction_s = 0.5;  ///< longer gaps are not bridged
};

struct NoLink {};

/// Between frames that nothing ties together: no state, no code.
struct NoLinks {
  using Link = NoLink;
  explicit NoLinks(const auto& /*options*/) {}
  static constexpr bool active() { return false; }
  void deactivate() {}
  void insert(int /*slot*/, const auto& /*state*/, const NoLink&) {}
  void remove(int /*slot*/) {}
  void set_judged(int /*slot*/, bool /*judged*/) {}
  void follow_biases(const auto& /*window*/) {}
  void for_each_row(const auto& /*window*/, int /*slot*/, auto&& /*take*/) const {}
  double cost(const auto& /*window*/) const { return 0; }
};

template <SensorRig SensorsT>
class ConstantVelocity {
 public:
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  using Layout = VisualLayout;
  using State = FrameValue<S, Layout>;
  using Options = ConstantVelocityOptions;
  template <int Slots>
  using Links = NoLinks;
  using Link = NoLink;
  static constexpr bool is_chain = false;

  ConstantVelocity(const Sensors&, const Options& options) : options_(options) {}

  static constexpr double calibrate(auto& /*rig*/, const auto& /*window*/) { return 0; }
  void begin_frame(TimeNs, const State* /*latest*/, S /*dt*/) {}
  const SE3<S>& T_body_cam(const SE3<S>& extrinsics) const { return extrinsics; }

  Prediction<State, S> predict(const State& latest, const View<Sensors>& view, S blind_s, auto&& align_motion) {
    SE3<S> T = latest.T_world_body;
    const bool goes_on = blind_s < S(options_.max_prediction_s);
    if (goes_on) T = plus(T, Vec<S, 6>(velocity_ * blind_s));
    T = turned_as_seen(T, view, align_motion);
    expected_ = minus(T, latest.T_world_body) / blind_s;
    const Vec<S, 3> w = segment<3>(expected_, 0), w_before = segment<3>(velocity_, 0);
    if (moves_ && goes_on) set_segment(expected_, 0, Vec<S, 3>(w + (w - w_before) / S(2)));
    return {{T}, {}};
  }
  /// When the image is taken, by a line through two intervals.               docs/math/rolling_shutter.md (1e)
  Vec<S, 3> angular_rate() const { return segment<3>(expected_, 0); }
  Vec<S, 3> velocity(const State&) const { return segment<3>(expected_, 3); }

  /// In the frame before, that being at T now: between its neighbours, or to this one where it has no other.
  Vec<S, 6> motion_before(const State& /*predicted*/, const SE3<S>& T, const View<Sensors>& view) const {
    const Vec<S, 6> after = minus(T, view.T_world_previous) / view.dt;
    return moves_ ? Vec<S, 6>((velocity_ + after) / S(2)) : after;
  }

  static constexpr bool contradicts(const Prediction<State, S>& /*predicted*/, const SE3<S>& /*T*/) { return false; }
  static constexpr bool admits(const Prediction<State, S>& /*predicted*/, const SE3<S>& /*T*/) { return true; }
  static constexpr S turned_wrongly() { return S(0); }
  State update(const State& /*predicted*/, const SE3<S>& T, const Mat<S, 6, 6>& /*covariance*/,
               const View<Sensors>& view) {
    velocity_ = minus(T, view.T_world_previous) / view.dt;
    moves_ = true;
    return {T};
  }
  bool revise(const State& /*before*/, State& /*solved*/, S /*dt*/) const { return false; }
  void lose() {
    set_zero(velocity_);
    moves_ = false;
  }
  static constexpr bool carries_on() { return false; }
  Mat<S, 6, 6> covariance_grown(const Mat<S, 6, 6>& before, S /*blind_s*/) const { return before; }
  /// Where the body was seen last.
  State restart(const State& latest) {
    lose();
    return latest;
  }

  static constexpr bool ties_frames() { return false; }
  static constexpr bool at_rest() { return false; }
  static constexpr bool may_rest(TimeNs /*t_ns*/) { return false; }
  bool confirm_keyframe(TimeNs, auto&& /*motion_px*/, bool needed) const { return needed; }
  Link link(int /*keyframe*/) const { return {}; }
  void begin_link(const State&) {}
  HealthReason doubt(const auto& /*links*/, const auto& /*window*/, bool /*few_features*/) const {
    return HealthReason::none;
  }

 private:
  Options options_;
  Vec<S, 6> velocity_ = zeros<S, 6>();  ///< of the last two frames [rad/s, m/s], body
  Vec<S, 6> expected_ = zeros<S, 6>();  ///< of this one [rad/s, m/s], body
  bool moves_ = false;                  ///< the velocity is known
};

}  // namespace plumbline
