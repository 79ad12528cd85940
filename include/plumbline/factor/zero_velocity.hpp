#pragma once
/// Factor of a body at rest between two frames: no motion since the first one, no velocity in the second one.
///                                                                                docs/math/inertial_window.md (1)

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/residual/zero_motion.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class S>
struct ZeroVelocityFactor {
  using Layout = InertialLayout;
  static constexpr int motion_dim = ZeroMotion<S>::dim, rows = motion_dim + ZeroVelocity<S>::dim;
  struct Linearized {
    Vec<S, rows> r;                      ///< whitened
    Mat<S, rows, Layout::dim> J_i, J_j;  ///< by the states of the two frames
  };

  double velocity_sigma;                  ///< [m/s]
  double rotation_sigma, position_sigma;  ///< of the motion between the frames [rad, m]

  /// At the states x; the Jacobians at the first estimates x_i0, x_j0.
  Linearized linearize(const NavState<S>& x_i, const NavState<S>& x_i0, const NavState<S>& x_j,
                       const NavState<S>& x_j0) const {
    constexpr int at_v = Layout::offset<state::Velocity>;
    const auto motion =
        ZeroMotion<S>{}.linearize(x_i.T_world_body, x_j.T_world_body, x_i0.T_world_body, x_j0.T_world_body);
    const auto velocity = ZeroVelocity<S>{}.linearize(x_j.v_world_body);
    const Vec<S, motion_dim> w = motion_weights();
    const S w_v = S(1 / velocity_sigma);
    Linearized out;
    set_zero(out.J_i);
    set_zero(out.J_j);
    for (int k = 0; k < motion_dim; ++k) {
      for (int c = 0; c < state::Pose::dim; ++c) {
        out.J_i(k, c) = w[k] * motion.J_r_i(k, c);
        out.J_j(k, c) = w[k] * motion.J_r_j(k, c);
      }
      out.r[k] = w[k] * motion.r[k];
    }
    for (int k = 0; k < ZeroVelocity<S>::dim; ++k) {
      for (int c = 0; c < state::Velocity::dim; ++c) out.J_j(motion_dim + k, at_v + c) = w_v * velocity.J_r_v(k, c);
      out.r[motion_dim + k] = w_v * velocity.r[k];
    }
    return out;
  }

  /// Adds |r|^2 / 2 to `sum`.
  void add_cost(const NavState<S>& x_i, const NavState<S>& x_j, double& sum) const {
    const Vec<S, 6> r = minus(x_j.T_world_body, x_i.T_world_body);
    sum += squared_norm(cwise_product(motion_weights(), r)) / 2;
    sum += squared_norm(x_j.v_world_body) / (2 * velocity_sigma * velocity_sigma);
  }

 private:
  Vec<S, 6> motion_weights() const {
    Vec<S, 6> w;
    for (int k = 0; k < 3; ++k) {
      w[k] = S(1 / rotation_sigma);
      w[3 + k] = S(1 / position_sigma);
    }
    return w;
  }
};

}  // namespace plumbline
