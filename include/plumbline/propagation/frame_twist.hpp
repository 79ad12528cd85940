#pragma once
/// Angular rate and velocity of the body while a frame is read out, by the gyroscope and, before initialization, by
/// images.                                                                        docs/math/rolling_shutter.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/imu_integrator.hpp"

namespace plumbline {

template <class S>
class FrameTwist {
 public:
  /// A new frame, dt [s] after the previous one, at the end of the samples: the angular rate there is extrapolated
  /// linearly from two means over the last window_s [s].                    docs/math/rolling_shutter.md (1d)
  void advance(const ImuIntegrator<S>& imu, const Vec<S, 3>& bias_gyro, S dt, double window_s) {
    rate_before_ = rate_;
    if (imu.since_frame().empty()) {
      rate_ = imu.since_frame().increment().delta.dR.log() / dt;
    } else {
      rate_ = 2 * imu.latest_gyro(window_s / 2) - imu.latest_gyro(window_s) - bias_gyro;
    }
  }

  const Vec<S, 3>& rate() const { return rate_; }                ///< in this frame [rad/s]
  const Vec<S, 3>& rate_before() const { return rate_before_; }  ///< in the previous frame [rad/s]

  /// Velocity [rad/s, m/s] of a body with that angular rate, and with the mean velocity of the last three images in the
  /// axes of R_world_body; it is at T now.                                    docs/math/rolling_shutter.md (1f)
  static Vec<S, 6> twist(const NavState<S>& predicted, const SE3<S>& T, const auto& view, const SO3<S>& R_world_body,
                         const Vec<S, 3>& rate) {
    const Vec<S, 3> v = (T.p() - view.T_world_previous.p()) / view.dt;
    Vec<S, 6> out;
    set_segment(out, 0, rate);
    set_segment(out, 3, Vec<S, 3>(R_world_body.inverse() * Vec<S, 3>((predicted.v_world_body + v) / S(2))));
    return out;
  }

 private:
  Vec<S, 3> rate_ = zeros<S, 3>(), rate_before_ = zeros<S, 3>();
};

}  // namespace plumbline
