#pragma once
/// State of a frame at its sample boundary: the pose at the image, moved back by the difference `delay` between the
/// present time offset and the one with which the boundary was computed.                        docs/math/camera_imu.md
///   R' = R Exp(-d w),   p' = p - d v,   v' = v,   b' = b,      w = gyro - b_g                                    (4)
///   dphi' = Exp(d w) dphi + d Jr(-d w) db_g - w dd,   dp' = Exp(d w) dp - R'^T (d dv + v dd)                       (5)
/// The velocity of a frame is defined at the boundary, where two IMU factors meet, so it is not moved.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <std::floating_point S>
struct TimeOffsetShift {
  S delay;         ///< d: time from the boundary to the image [s]
  Vec<S, 3> gyro;  ///< mean angular rate before the boundary, with bias [rad/s]

  /// The state at the boundary, (4).
  NavState<S> operator()(const NavState<S>& x) const {
    NavState<S> out = x;
    if (delay == S(0)) return out;
    const SE3<S>& T = x.T_world_body;
    out.T_world_body = SE3<S>(T.rotation() * SO3<S>::exp(-delay * rate(x)), T.p() - delay * x.v_world_body);
    return out;
  }

  /// Chains rows J by the moved state to rows by the state x; returns the derivatives by d.                      (5)
  template <int Rows>
  Vec<S, Rows> pull_back(const NavState<S>& x, Mat<S, Rows, 15>& J) const {
    using Rows3 = Mat<S, Rows, 3>;
    constexpr int position = 3, velocity = 6, gyro_bias = 9;
    const Vec<S, 3> w = rate(x), turned = -delay * w;
    const SO3<S> R_back = SO3<S>::exp(turned).inverse();
    const Rows3 J_phi = block<Rows, 3>(J, 0, 0), J_p = block<Rows, 3>(J, 0, position);
    const Rows3 J_world = product(J_p, (R_back * x.T_world_body.rotation().inverse()).matrix());
    Vec<S, Rows> by_delay = -(J_phi * w + J_world * x.v_world_body);
    if (delay == S(0)) return by_delay;
    set_block(J, 0, 0, product(J_phi, R_back.matrix()));
    set_block(J, 0, position, product(J_p, R_back.matrix()));
    set_block(J, 0, velocity, Rows3(block<Rows, 3>(J, 0, velocity) - delay * J_world));
    set_block(J, 0, gyro_bias,
              Rows3(block<Rows, 3>(J, 0, gyro_bias) + delay * product(J_phi, SO3<S>::right_jacobian(turned))));
    return by_delay;
  }

 private:
  /// w of (4).
  Vec<S, 3> rate(const NavState<S>& x) const { return gyro - x.bias_gyro; }
};

}  // namespace plumbline
