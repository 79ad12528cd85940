#pragma once
/// Propagation of a rig without IMU: constant velocity, in the axes of the body. The predicted rotation is replaced by
/// that of image alignment where it is valid; the translation is dropped where the images fit better without it. There
/// are no factors between frames.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_state.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

struct ConstantVelocityOptions {
  /// Longest time over which the velocity is extrapolated [s]; tuned: docs/decisions/130 (chosen).
  double max_prediction_s = 0.5;
};

struct NoFactor {};

/// The factors of a propagation without any: no state, no code.
struct NoFactors {
  using Factor = NoFactor;
  explicit NoFactors(const auto& /*options*/) {}
  static constexpr bool active() { return false; }
  void deactivate() {}
  void insert(int /*slot*/, const auto& /*state*/, const NoFactor&) {}
  void remove(int /*slot*/) {}
  void set_checked(int /*slot*/, bool /*checked*/) {}
  void reintegrate(const auto& /*window*/) {}
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
  using Factors = NoFactors;
  using Factor = NoFactor;
  static constexpr bool has_imu_factors = false;

  ConstantVelocity(const Sensors&, const Options& options) : options_(options) {}

  static constexpr double calibrate(auto& /*rig*/, const auto& /*window*/) { return 0; }
  void begin_frame(TimeNs, const State* /*latest*/, S /*dt*/) {}
  const SE3<S>& T_body_cam(const SE3<S>& extrinsics) const { return extrinsics; }

  Prediction<State, S> predict(const State& latest, const View<Sensors>& view, S outage_s, auto&& align_motion) {
    SE3<S> T = latest.T_world_body;
    const bool is_recent = outage_s < S(options_.max_prediction_s);
    if (is_recent) T = plus(T, Vec<S, 6>(velocity_ * outage_s));
    T = with_image_rotation(T, view, align_motion);
    expected_ = minus(T, latest.T_world_body) / outage_s;
    const Vec<S, 3> w = segment<3>(expected_, 0), w_before = segment<3>(velocity_, 0);
    if (has_velocity_ && is_recent) set_segment(expected_, 0, Vec<S, 3>(w + (w - w_before) / S(2)));
    return {{T}, {}};
  }
  /// Angular rate when the image is taken, extrapolated from two intervals.  docs/math/rolling_shutter.md (1e)
  Vec<S, 3> angular_rate() const { return segment<3>(expected_, 0); }
  Vec<S, 3> velocity(const State&) const { return segment<3>(expected_, 3); }

  /// Velocity [rad/s, m/s] in the previous frame, this frame being at T: the mean of the intervals before and after it,
  /// or the latter alone.                                                    docs/math/rolling_shutter.md (1c)
  Vec<S, 6> motion_before(const State& /*predicted*/, const SE3<S>& T, const View<Sensors>& view) const {
    const Vec<S, 6> after = minus(T, view.T_world_previous) / view.dt;
    return has_velocity_ ? Vec<S, 6>((velocity_ + after) / S(2)) : after;
  }

  static constexpr bool contradicts(const Prediction<State, S>& /*predicted*/, const SE3<S>& /*T*/) { return false; }
  static constexpr bool passes_gate(const Prediction<State, S>& /*predicted*/, const SE3<S>& /*T*/) { return true; }
  static constexpr S gyro_jump_rotation() { return S(0); }
  State update(const State& /*predicted*/, const SE3<S>& T, const Mat<S, 6, 6>& /*covariance*/,
               const View<Sensors>& view) {
    velocity_ = minus(T, view.T_world_previous) / view.dt;
    has_velocity_ = true;
    return {T};
  }
  bool correct(const State& /*before*/, State& /*solved*/, S /*dt*/) const { return false; }
  void mark_lost() {
    set_zero(velocity_);
    has_velocity_ = false;
  }
  static constexpr bool can_propagate() { return false; }
  Mat<S, 6, 6> grown_covariance(const Mat<S, 6, 6>& before, S /*outage_s*/) const { return before; }
  /// Restarts at the last pose.
  State restart(const State& latest) {
    mark_lost();
    return latest;
  }

  static constexpr bool is_initialized() { return false; }
  static constexpr bool is_stationary() { return false; }
  static constexpr bool can_be_stationary(TimeNs /*t_ns*/) { return false; }
  static constexpr bool detect_stationarity(TimeNs /*t_ns*/, double /*track_px*/) { return false; }
  bool confirm_keyframe(TimeNs, auto&& /*motion_px*/, bool needed) const { return needed; }
  Factor factor(int /*keyframe*/) const { return {}; }
  void begin_factor() {}
  static constexpr bool is_inconsistent() { return false; }
  HealthReason diagnose(const auto& /*factors*/, const auto& /*window*/, bool /*few_features*/) const {
    return HealthReason::none;
  }

 private:
  Options options_;
  Vec<S, 6> velocity_ = zeros<S, 6>();  ///< of the last two frames, in the body [rad/s, m/s]
  Vec<S, 6> expected_ = zeros<S, 6>();  ///< of the predicted frame, in the body [rad/s, m/s]
  bool has_velocity_ = false;           ///< velocity_ is determined
};

}  // namespace plumbline
