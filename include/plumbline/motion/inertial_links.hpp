#pragma once
/// The IMU's increments between the frames of a window.                                docs/math/inertial_window.md
///
/// A frame's increment comes from the frame before it; together they are a chain in time. Where a frame was
/// marginalized the chain is cut, and the prior holds the ends together.

#include <array>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/motion/camera_clock.hpp"
#include "plumbline/residual/clock_shift.hpp"
#include "plumbline/residual/inertial.hpp"
#include "plumbline/residual/zero_motion.hpp"
#include "plumbline/state/estimated.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct InertialLinkOptions {
  double gravity = standard_gravity<double>;  ///< length of the acceleration of free fall [m/s^2]
  double rest_velocity_sigma = 0.01;          ///< of a body found at rest [m/s]
  double rest_rotation_sigma = 2e-3;          ///< between two frames of one standstill [rad]
  double rest_position_sigma = 2e-3;          ///< [m]
  double accel_doubt = 20;      ///< of an accelerometer that does not tell of the motion seen, sigma [m/s^2]
  double jump_gyro_bias = 0.2;  ///< of a link in which the gyroscope's bias jumped, sigma [rad/s]
};

/// What ties a frame to the one in slot `previous`, -1 for none.
template <class S>
struct InertialLink {
  int previous = -1;
  Preintegration<S> increment;         ///< since then
  bool at_rest = false;                ///< the body did not move since then
  bool jumped = false;                 ///< the gyroscope's bias is another one since then
  ReadingCut<S> begin = {}, end = {};  ///< where its readings begin and end
  bool accel_in_doubt = false;         ///< the accelerometer does not tell of the motion
};

template <class S, int Slots>
class InertialLinks {
 public:
  using Layout = InertialLayout;
  using Increment = Preintegration<S>;
  using Link = InertialLink<S>;

  explicit InertialLinks(const InertialLinkOptions& options)
      : options_(options), gravity_(gravity_in_world<S>(S(options.gravity))) {}

  const Vec<S, 3>& gravity() const { return gravity_; }

  /// Links take part in the cost from `activate` on; before, velocities and biases rest where they are.
  bool active() const { return active_; }
  void activate() { active_ = true; }
  void deactivate() { active_ = false; }

  /// An accelerometer that is found to be wrong was so before.
  void insert(int slot, const NavState<S>& x, const Link& link) {
    if (link.accel_in_doubt && !accel_in_doubt_) doubt_accelerometer();
    accel_in_doubt_ = link.accel_in_doubt;
    links_[slot].link = link;
    links_[slot].judged = true;
    integrate(links_[slot], x);
  }
  /// The frame leaves; what it tied together is in the prior or given up.
  void remove(int slot) {
    links_[slot].link.previous = -1;
    for (Weighted& weighted : links_) {
      if (weighted.link.previous == slot) weighted.link.previous = -1;
    }
  }

  int previous(int slot) const { return links_[slot].link.previous; }
  const Increment& increment(int slot) const { return links_[slot].link.increment; }

  /// From position to position, biases and attitudes given.
  template <class Window>
  void guess_velocities(Window& window) const {
    using Velocity = Estimated<state::Velocity, S>;
    const auto set = [&](int slot, const Vec<S, 3>& v) {
      window.state(slot).template get<state::Velocity>() = Velocity(v);
    };
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const auto& increment = links_[j].link.increment.increment();
      const int i = previous(j);
      NavState<S> x_i = window[i].state.value();
      set_zero(x_i.v_world_body);
      const NavState<S> fallen = increment.predict(x_i, gravity_);
      x_i.v_world_body = (window.T_world_body(j).p() - fallen.T_world_body.p()) / increment.duration;
      set(i, x_i.v_world_body);
      set(j, increment.predict(x_i, gravity_).v_world_body);
    }
  }

  /// Integrates again what the biases of its frame have moved away from. Call it between optimizations.
  void follow_biases(const auto& window) {
    for (int slot = 0; slot < Slots; ++slot) {
      if (!linked(window, slot)) continue;
      const NavState<S> x = window[previous(slot)].state.value();
      if (links_[slot].link.increment.is_far(x.bias_gyro)) integrate(links_[slot], x);
    }
  }

  /// Linearizes all links that touch `slot`, all of them for -1, and gives take(i, J_i, j, J_j, J_clock, r) their
  /// whitened rows, J_clock by the offset of the camera's clock.
  void for_each_row(const auto& window, int slot, auto&& take) const {
    for (int j = 0; active_ && j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const Weighted& weighted = links_[j];
      const int i = weighted.link.previous;
      if (slot >= 0 && i != slot && j != slot) continue;
      const NavState<S> x_i = window[i].state.value(), x_j = window[j].state.value();
      const NavState<S> x_i0 = window[i].state.first_estimate(), x_j0 = window[j].state.first_estimate();
      if (weighted.valid) {
        const Ends at = ends(window, weighted.link);
        auto inertial = InertialResidual<S>{weighted.link.increment.increment(), gravity_}.linearize(
            at.begin(x_i), at.end(x_j), at.begin(x_i0), at.end(x_j0));
        if (inertial.valid) {
          inertial.whiten(weighted.L);
          const Vec<S, 15> by_begin = at.begin.pull_back(x_i0, inertial.J_r_i);
          const Vec<S, 15> J_clock = by_begin + at.end.pull_back(x_j0, inertial.J_r_j);
          take(i, inertial.J_r_i, j, inertial.J_r_j, J_clock, inertial.r);
        }
      }
      if (weighted.link.at_rest) take_rest(i, x_i, x_i0, j, x_j, x_j0, take);
    }
  }

  double cost(const auto& window) const {
    double sum = 0;
    for (int j = 0; active_ && j < Slots; ++j) {
      if (!linked(window, j)) continue;
      const Weighted& weighted = links_[j];
      const NavState<S> x_i = window[weighted.link.previous].state.value(), x_j = window[j].state.value();
      if (weighted.valid) {
        const Ends at = ends(window, weighted.link);
        const Vec<S, 15> r =
            InertialResidual<S>{weighted.link.increment.increment(), gravity_}.residual(at.begin(x_i), at.end(x_j));
        sum += squared_norm(times(weighted.L, r)) / 2;
      }
      if (!weighted.link.at_rest) continue;
      const Vec<S, 6> r = minus(x_j.T_world_body, x_i.T_world_body);
      sum += squared_norm(cwise_product(rest_weights(), r)) / 2;
      sum += squared_norm(x_j.v_world_body) / (2 * options_.rest_velocity_sigma * options_.rest_velocity_sigma);
    }
    return sum;
  }

  /// A link whose ends were not estimated together: how well they agree says nothing about the readings.
  void set_judged(int slot, bool judged) { links_[slot].judged = judged; }
  /// Mean squared whitened residual of rotation, position and velocity over all increments: about 1 where the readings
  /// agree with the states as well as their noise allows, 0 without increments.
  double disagreement(const auto& window) const {
    constexpr int compared = Layout::dim - state::GyroBias::dim - state::AccelBias::dim;  // biases hardly contribute
    double sum = 0;
    int links = 0;
    for (int j = 0; j < Slots; ++j) {
      if (!linked(window, j) || !links_[j].valid || !links_[j].judged) continue;
      const InertialResidual<S> inertial{links_[j].link.increment.increment(), gravity_};
      const Ends at = ends(window, links_[j].link);
      const Vec<S, 15> r =
          inertial.residual(at.begin(window[previous(j)].state.value()), at.end(window[j].state.value()));
      sum += squared_norm(times(links_[j].L, r));
      ++links;
    }
    return links > 0 ? sum / (compared * links) : 0;
  }

 private:
  struct Weighted {
    Link link;
    bool valid = false;  ///< its increment has a weight
    bool judged = true;  ///< by `disagreement`
    Mat<S, 15, 15> L;    ///< whitens the increment's residual
  };

  /// From the images' times, by the camera's clock as it is seen now, to where the readings begin and end.
  struct Ends {
    ClockShift<S> begin, end;
  };
  Ends ends(const auto& window, const Link& link) const {
    const auto shift = [&](const ReadingCut<S>& cut) { return cut.shift(window.time_offset_s(cut.offset_s)); };
    return {shift(link.begin), shift(link.end)};
  }

  bool linked(const auto& window, int slot) const { return window[slot].used && previous(slot) >= 0; }

  void doubt_accelerometer() {
    for (Weighted& weighted : links_) {
      if (weighted.link.previous < 0) continue;
      weighted.link.increment.doubt_accelerometer(S(options_.accel_doubt));
      weigh(weighted);
    }
  }
  void integrate(Weighted& weighted, const NavState<S>& x) const {
    weighted.link.increment.reintegrate(x.bias_gyro, x.bias_accel);
    weigh(weighted);
  }
  void weigh(Weighted& weighted) const {
    const Increment& increment = weighted.link.increment;
    const auto L = weighted.link.jumped ? square_root_information(loosened(increment.increment()))
                                        : increment.increment().square_root_information();
    weighted.valid = bool(L) && !increment.empty();
    if (weighted.valid) weighted.L = *L;
  }

  /// What the readings say where nobody knows with which bias: rotation, and with it velocity and position, are open.
  Mat<S, 15, 15> loosened(const ImuIncrement<S>& increment) const {
    Mat<S, 15, 15> P = increment.covariance;
    const S jump = S(options_.jump_gyro_bias), t = increment.duration, rotation = jump * t;
    const S velocity = S(options_.gravity) * rotation * t / 2, position = velocity * t / 3;
    for (int k = 0; k < 3; ++k) {
      P(k, k) += rotation * rotation;
      P(3 + k, 3 + k) += position * position;
      P(6 + k, 6 + k) += velocity * velocity;
      P(Layout::offset<state::GyroBias> + k, Layout::offset<state::GyroBias> + k) += jump * jump;
    }
    return P;
  }

  /// Rows of a standstill: no motion since frame i, no velocity in frame j.
  void take_rest(int i, const NavState<S>& x_i, const NavState<S>& x_i0, int j, const NavState<S>& x_j,
                 const NavState<S>& x_j0, auto&& take) const {
    constexpr int motion_dim = ZeroMotion<S>::dim, rows = motion_dim + ZeroVelocity<S>::dim;
    constexpr int at_v = Layout::offset<state::Velocity>;
    const auto motion =
        ZeroMotion<S>{}.linearize(x_i.T_world_body, x_j.T_world_body, x_i0.T_world_body, x_j0.T_world_body);
    const auto velocity = ZeroVelocity<S>{}.linearize(x_j.v_world_body);
    const Vec<S, motion_dim> w = rest_weights();
    const S w_v = S(1 / options_.rest_velocity_sigma);
    Mat<S, rows, Layout::dim> J_i, J_j;
    Vec<S, rows> r;
    set_zero(J_i);
    set_zero(J_j);
    for (int k = 0; k < motion_dim; ++k) {
      for (int c = 0; c < state::Pose::dim; ++c) {
        J_i(k, c) = w[k] * motion.J_r_i(k, c);
        J_j(k, c) = w[k] * motion.J_r_j(k, c);
      }
      r[k] = w[k] * motion.r[k];
    }
    for (int k = 0; k < ZeroVelocity<S>::dim; ++k) {
      for (int c = 0; c < state::Velocity::dim; ++c) J_j(motion_dim + k, at_v + c) = w_v * velocity.J_r_v(k, c);
      r[motion_dim + k] = w_v * velocity.r[k];
    }
    take(i, J_i, j, J_j, zeros<S, rows>(), r);
  }

  Vec<S, 6> rest_weights() const {
    Vec<S, 6> w;
    for (int k = 0; k < 3; ++k) {
      w[k] = S(1 / options_.rest_rotation_sigma);
      w[3 + k] = S(1 / options_.rest_position_sigma);
    }
    return w;
  }

  InertialLinkOptions options_;
  Vec<S, 3> gravity_;
  bool active_ = false, accel_in_doubt_ = false;
  std::array<Weighted, Slots> links_;
};

}  // namespace plumbline
