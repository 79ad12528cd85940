#pragma once
/// Velocities and biases of a window's frames, and the IMU's increments between them.     docs/math/inertial_window.md
///
/// A frame's increment comes from the frame before it; together they are a chain in time. Where a frame was
/// marginalized the chain is cut, and the prior holds the ends together. Motions follow the rule of WindowPose: once a
/// prior refers to one, its linearization point stays and it moves by a correction e.

#include <array>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/mapping/frame_window.hpp"
#include "plumbline/residual/inertial.hpp"
#include "plumbline/residual/zero_motion.hpp"

namespace plumbline {

struct InertialOptions {
  double gravity = standard_gravity<double>;
  double rest_velocity_sigma = 0.01;    ///< of a body found at rest [m/s]
  double rest_rotation_sigma = 2e-3;    ///< between two frames of one standstill [rad]
  double rest_position_sigma = 2e-3;    ///< [m]
  double start_gyro_bias_sigma = 0.02;  ///< prior of the first frame [rad/s]
  double start_accel_bias_sigma = 0.1;  ///< [m/s^2]
};

template <class S, int Slots>
class InertialChain {
 public:
  static constexpr int state_dim = 15;
  using Window = FrameWindow<S, Slots>;
  using Increment = Preintegration<S>;

  explicit InertialChain(const InertialOptions& options)
      : options_(options), gravity_(gravity_in_world<S>(S(options.gravity))) {}

  const InertialOptions& options() const { return options_; }
  const Vec<S, 3>& gravity() const { return gravity_; }

  NavState<S> state(const Window& window, int slot) const {
    return to_state(window[slot].pose.value(), motions_[slot].value);
  }
  /// Of velocity and biases, [dv, dbg, dba].
  const Vec<S, 9>& correction(int slot) const { return motions_[slot].e; }

  /// A frame with the increment since `previous`, -1 for none. `at_rest`: the body did not move since then.
  void insert(int slot, const NavState<S>& x, int previous, const Increment& increment, bool at_rest) {
    motions_[slot] = {};
    set_motion(slot, x);
    Link& link = links_[slot];
    link.previous = previous;
    link.increment = increment;
    link.at_rest = at_rest;
    update(link, x);
  }
  void set_motion(int slot, const NavState<S>& x) {
    motions_[slot].value << x.v_world_body, x.bias_gyro, x.bias_accel;
    motions_[slot].e.setZero();
    motions_[slot].fixed = false;
  }
  void fix_linearization_point(int slot) { motions_[slot].fixed = true; }

  /// From position to position, biases and attitudes given.
  void guess_velocities(const Window& window) {
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const auto& increment = links_[j].increment.increment();
      NavState<S> x_i = state(window, links_[j].previous), x_j = state(window, j);
      x_i.v_world_body.setZero();
      const NavState<S> fallen = increment.predict(x_i, gravity_);
      x_i.v_world_body = (x_j.T_world_body.p() - fallen.T_world_body.p()) / increment.duration;
      motions_[links_[j].previous].value.template head<3>() = x_i.v_world_body;
      motions_[j].value.template head<3>() = increment.predict(x_i, gravity_).v_world_body;
    }
  }

  int previous(int slot) const { return links_[slot].previous; }
  const Increment& increment(int slot) const { return links_[slot].increment; }

  /// Integrates again what the biases of its frame have moved away from. Call it between optimizations.
  void follow_biases(const Window& window) {
    for (int slot = 0; slot < Slots; ++slot) {
      if (!linked(window, slot)) continue;
      const NavState<S> x = state(window, links_[slot].previous);
      if (links_[slot].increment.is_far(x.bias_gyro)) update(links_[slot], x);
    }
  }

  /// The frame leaves; what it tied together is in the prior or given up.
  void remove(int slot) {
    links_[slot].previous = -1;
    for (Link& link : links_) {
      if (link.previous == slot) link.previous = -1;
    }
  }

  /// Linearizes all links that touch `slot`, all of them for -1, and gives take(i, J_i, j, J_j, r) their whitened rows.
  void for_each_row(const Window& window, int slot, auto&& take) const {
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const Link& link = links_[j];
      const int i = link.previous;
      if (slot >= 0 && i != slot && j != slot) continue;
      const NavState<S> x_i = state(window, i), x_j = state(window, j);
      const NavState<S> x_i0 = first_estimate(window, i), x_j0 = first_estimate(window, j);
      if (link.weighted) {
        auto inertial = InertialResidual<S>{link.increment.increment(), gravity_}.linearize(x_i, x_j, x_i0, x_j0);
        if (inertial.valid) {
          inertial.whiten(link.L);
          take(i, inertial.J_r_i, j, inertial.J_r_j, inertial.r);
        }
      }
      if (!link.at_rest) continue;
      const auto rest =
          ZeroMotion<S>{}.linearize(x_i.T_world_body, x_j.T_world_body, x_i0.T_world_body, x_j0.T_world_body);
      const Vec<S, 6> w = rest_weights();
      const S w_v = S(1 / options_.rest_velocity_sigma);
      Mat<S, 9, 15> J_i, J_j;
      Vec<S, 9> r;
      J_i.setZero();
      J_j.setZero();
      for (int k = 0; k < 6; ++k) {
        for (int c = 0; c < 6; ++c) {
          J_i(k, c) = w[k] * rest.J_r_i(k, c);
          J_j(k, c) = w[k] * rest.J_r_j(k, c);
        }
        r[k] = w[k] * rest.r[k];
      }
      for (int k = 0; k < 3; ++k) {
        J_j(6 + k, 6 + k) = w_v;
        r[6 + k] = w_v * x_j.v_world_body[k];
      }
      take(i, J_i, j, J_j, r);
    }
  }

  double cost(const Window& window) const {
    double sum = 0;
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const Link& link = links_[j];
      const NavState<S> x_i = state(window, link.previous), x_j = state(window, j);
      if (link.weighted) {
        const Vec<S, 15> r = InertialResidual<S>{link.increment.increment(), gravity_}.residual(x_i, x_j);
        sum += Vec<S, 15>(link.L.lazyProduct(r)).squaredNorm() / 2;
      }
      if (!link.at_rest) continue;
      const Vec<S, 6> r = minus(x_j.T_world_body, x_i.T_world_body);
      sum += rest_weights().cwiseProduct(r).squaredNorm() / 2;
      sum += x_j.v_world_body.squaredNorm() / (2 * options_.rest_velocity_sigma * options_.rest_velocity_sigma);
    }
    return sum;
  }

  /// Mean squared whitened residual of rotation, position and velocity over all increments: about 1 where the readings
  /// agree with the states as well as their noise allows, 0 without increments.
  double disagreement(const Window& window) const {
    double sum = 0;
    int links = 0;
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j) || !links_[j].weighted) continue;
      const InertialResidual<S> inertial{links_[j].increment.increment(), gravity_};
      sum += Vec<S, 15>(links_[j].L.lazyProduct(inertial.residual(state(window, links_[j].previous), state(window, j))))
                 .squaredNorm();
      ++links;
    }
    return links > 0 ? sum / (9 * links) : 0;  // those of the biases hardly contribute
  }

  void step(int slot, const Vec<S, 9>& d) {
    Motion& motion = motions_[slot];
    motion.value += d;
    if (motion.fixed) motion.e += d;
  }
  void backup() { backup_ = motions_; }
  void restore() { motions_ = backup_; }

 private:
  struct Motion {
    Vec<S, 9> value = Vec<S, 9>::Zero(), e = Vec<S, 9>::Zero();  ///< [v, bg, ba]; its linearization point is value - e
    bool fixed = false;
  };
  struct Link {
    int previous = -1;
    bool at_rest = false, weighted = false;
    Increment increment;
    Mat<S, 15, 15> L;  ///< whitens the increment's residual
  };

  static NavState<S> to_state(const SE3<S>& T_world_body, const Vec<S, 9>& motion) {
    return {T_world_body, motion.template head<3>(), motion.template segment<3>(3), motion.template tail<3>()};
  }
  NavState<S> first_estimate(const Window& window, int slot) const {
    return to_state(window[slot].pose.linearization_point(), motions_[slot].value - motions_[slot].e);
  }
  bool linked(const Window& window, int slot) const { return window[slot].used && links_[slot].previous >= 0; }

  void update(Link& link, const NavState<S>& x) {
    link.increment.reintegrate(x.bias_gyro, x.bias_accel);
    const auto L = link.increment.increment().square_root_information();
    link.weighted = bool(L) && !link.increment.empty();
    if (link.weighted) link.L = *L;
  }

  Vec<S, 6> rest_weights() const {
    Vec<S, 6> w;
    w << Vec<S, 3>::Constant(S(1 / options_.rest_rotation_sigma)),
        Vec<S, 3>::Constant(S(1 / options_.rest_position_sigma));
    return w;
  }

  InertialOptions options_;
  Vec<S, 3> gravity_;
  std::array<Motion, Slots> motions_, backup_;
  std::array<Link, Slots> links_;
};

}  // namespace plumbline
