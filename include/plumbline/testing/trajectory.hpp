#pragma once
/// Smooth paths through the simulated scenes with exact derivatives.
///
/// Position and yaw, pitch, roll are sums of sinusoids of the phase s(t), in the ring beside its center line
/// (testing/ring_path.hpp). s is constant up to t_0, gains speed during T (C^5), and may be constant again from b to e;
/// s = t for a camera shaken by hand:
///   s(t) = r(t - t_0) - r(t - b) + r(t - e),  r(t) = ramp(t, T) of testing/jet.hpp                               (1)
///   R_world_body = Rz(yaw) Ry(pitch) Rx(roll)                                                                    (2)
///   w_body = [roll' - yaw' sin pitch;  pitch' cos roll + yaw' cos pitch sin roll;
///             -pitch' sin roll + yaw' cos pitch cos roll]
/// Derivatives are exact: second-order Taylor arithmetic (`Jet`).
/// Body: x forward, y left, z up; world: z up, g = (0, 0, -9.81) m/s^2.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>

#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/jet.hpp"
#include "plumbline/testing/ring_path.hpp"

namespace plumbline::testing {

/// The exact motion of the body at one time.
struct MotionState {
  SE3<double> T_world_body;
  Vec<double, 3> v_world_body;  ///< [m/s]
  Vec<double, 3> a_world_body;  ///< [m/s^2]
  Vec<double, 3> w_body;        ///< angular rate in the body frame [rad/s]

  static Vec<double, 3> gravity() { return {0, 0, -9.81}; }
  /// The measurement of an ideal accelerometer: R^T (a - g) [m/s^2].
  Vec<double, 3> specific_force() const {
    return T_world_body.rotation().inverse() * Vec<double, 3>(a_world_body - gravity());
  }
};

class Trajectory {
 public:
  static constexpr double stationary_s = 1.0, ramp_s = 1.0;

  /// The path of that scene, its sway varied by the seed; nothing when the name is unknown.
  static std::optional<Trajectory> for_scene(std::string_view scene, std::uint64_t seed = 1) {
    if (scene == "room" || scene == "room_lowtex" || scene == "boards") return Trajectory(Kind::room, seed);
    if (scene == "corridor") return Trajectory(Kind::corridor, seed);
    if (scene == "walk") return Trajectory(Kind::walk, seed);
    if (scene == "hall") return Trajectory(Kind::hall, seed);
    if (scene == "ring" || scene == "doors") return Trajectory(Kind::ring, seed);
    if (scene == "tiles") return Trajectory(Kind::facade, seed);
    return std::nullopt;
  }

  /// In the middle of the room, shaken by hand at 2 to 4 Hz from the first instant on: up to 5 rad/s and 20 m/s^2.
  static Trajectory shaken(std::uint64_t seed = 1) { return Trajectory(Kind::shaken, seed); }

  /// Time of one lap at full speed [s]; then the body is near the same place, the sway differs. A hand-held walk varies
  /// its speed: its laps differ by a second.
  double lap_s() const {
    switch (kind_) {
      case Kind::room: return 13;
      case Kind::corridor: return 18;
      case Kind::walk: return 18 / 0.92;
      case Kind::hall: return 45;
      case Kind::ring: return RingPath::lap / ring_speed;
      case Kind::facade: return 2 * std::numbers::pi * facade_reach / ring_speed;
      case Kind::shaken: break;
    }
    return 0;
  }
  /// Time at which so many laps are complete, with the stationary time before [s].
  double end_of_lap_s(int laps) const { return stationary_s + speed_up_s() / 2 + laps * lap_s(); }

  /// Slows down at begin_s, which takes as long as speeding up at the begin, and continues from end_s.
  void stop(double begin_s, double end_s) {
    stop_s_ = begin_s;
    go_s_ = end_s;
  }

  MotionState at(double t) const {
    const Jet s = kind_ == Kind::shaken ? Jet{t, 1, 0} : phase(t);
    Jet x, y, z, yaw, pitch, roll;
    const auto sway = [&](std::size_t i, double amplitude, double rate) {
      return amplitude * sin(rate * s + phase_[i]);
    };
    if (kind_ == Kind::room) {  // around the middle, looking out at the walls
      const Jet turn = (2 * std::numbers::pi / 13) * s + start_;
      x = 1.05 * cos(turn) + sway(0, 0.12, 1.1);
      y = 0.85 * sin(turn) + sway(1, 0.12, 0.9);
      z = sway(2, 0.16, 0.8) + sway(3, 0.02, 3.1) + 1.35;
      yaw = turn + sway(4, 0.45, 0.75) + sway(5, 0.04, 2.7);
    } else if (kind_ == Kind::shaken) {
      x = sway(0, 0.030, 13.5) + sway(1, 0.20, 2.1);
      y = sway(2, 0.025, 16.5) + sway(3, 0.20, 1.7);
      z = sway(4, 0.018, 22.0) + sway(5, 0.08, 2.6) + 1.35;
      yaw = sway(6, 0.18, 14.5) + start_;
      return motion(x, y, z, yaw, sway(7, 0.10, 18.0) + sway(9, 0.10, 1.9) + 0.12, sway(8, 0.10, 20.5));
    } else if (kind_ == Kind::hall) {  // a wide round, looking ahead and at the walls
      const Jet turn = (2 * std::numbers::pi / 45) * s + start_;
      x = 8.0 * cos(turn) + sway(0, 0.25, 0.5);
      y = 4.5 * sin(turn) + sway(1, 0.25, 0.4);
      z = sway(2, 0.20, 0.5) + sway(3, 0.01, 5.0) + 1.6;
      yaw = turn + sway(4, 0.35, 0.45) + sway(5, 0.03, 2.1);
    } else if (kind_ == Kind::ring) {  // on the center line of the corridor, looking ahead and at the outer wall
      const RingPath path = RingPath::at(ring_speed * s + RingPath::lap * start_ / (2 * std::numbers::pi));
      x = path.x + sway(0, 0.05, 1.1);
      y = path.y + sway(1, 0.05, 1.3);
      z = sway(2, 0.05, 0.8) + sway(3, 0.008, 9.0) + 1.4;
      yaw = path.heading + sway(4, 0.22, 1.1) + sway(5, 0.03, 2.7) + (-0.4);
    } else if (kind_ == Kind::facade) {  // along the facade and back, facing it
      x = facade_reach * sin((ring_speed / facade_reach) * s + start_) + sway(0, 0.05, 1.1);
      y = sway(1, 0.08, 0.9);
      z = sway(2, 0.06, 0.8) + sway(3, 0.008, 9.0) + 1.4;
      yaw = sway(4, 0.22, 0.9) + sway(5, 0.03, 2.7) + std::numbers::pi / 2;
    } else {  // one lap of the corridor in 18 s: a rectangle with round corners, slower there
      const Jet u = kind_ == Kind::walk ? 0.92 * s + 0.5 * sin(0.5 * s + phase_[9]) : s;
      const Jet turn = (2 * std::numbers::pi / 18) * u;
      const Jet angle = turn + (-0.06) * sin(4 * turn);
      x = 2.3 * (1.125 * cos(angle) + (-0.125) * cos(3 * angle)) + sway(0, 0.05, 1.1);
      y = 1.9 * (1.125 * sin(angle) + 0.125 * sin(3 * angle)) + sway(1, 0.05, 1.3);
      z = sway(2, 0.05, 0.8) + sway(3, 0.008, 9.0) + 1.4;
      yaw = turn + (-0.17) * sin(4 * turn) + sway(4, 0.22, 1.1) + sway(5, 0.03, 2.7) + std::numbers::pi / 2;
    }
    pitch = sway(6, 0.12, 1.2) + sway(7, 0.02, 3.7) + 0.12;
    roll = sway(8, 0.07, 1.0) + sway(9, 0.015, 4.1);
    if (kind_ == Kind::walk) {  // steps at 1.8 Hz, which the body swings with at half of that, and a hand that trembles
      x = x + sway(4, 0.010, 5.7) + sway(5, 0.002, 15.0);
      y = y + sway(6, 0.010, 5.7) + sway(7, 0.002, 17.0);
      z = z + sway(8, 0.008, 11.4);
      yaw = yaw + sway(0, 0.020, 5.7) + sway(1, 0.006, 16.0);
      pitch = pitch + sway(2, 0.012, 11.4) + sway(3, 0.006, 18.0);
      roll = roll + sway(7, 0.018, 5.7);
    }
    return motion(x, y, z, yaw, pitch, roll);
  }

 private:
  static constexpr double ring_speed = 1.2;     ///< [m/s] also the largest along the facade
  static constexpr double facade_reach = 11.7;  ///< [m] to both sides; the sway has no common period with it

  enum class Kind : std::uint8_t { room, corridor, walk, hall, ring, facade, shaken };

  static MotionState motion(const Jet& x, const Jet& y, const Jet& z, const Jet& yaw, const Jet& pitch,
                            const Jet& roll) {
    const double sp = std::sin(pitch.value), cp = std::cos(pitch.value), sr = std::sin(roll.value),
                 cr = std::cos(roll.value);
    const auto turned = [](int axis, const Jet& angle) {
      return SO3<double>::exp(angle.value * Vec<double, 3>::Unit(axis));
    };
    return {SE3<double>(turned(2, yaw) * turned(1, pitch) * turned(0, roll), {x.value, y.value, z.value}),
            {x.d1, y.d1, z.d1},
            {x.d2, y.d2, z.d2},
            {roll.d1 - yaw.d1 * sp, pitch.d1 * cr + yaw.d1 * cp * sr, -pitch.d1 * sr + yaw.d1 * cp * cr}};  // (2)
  }

  Trajectory(Kind kind, std::uint64_t seed) : kind_(kind) {
    Random random(stream_seed(seed, 1));
    for (double& p : phase_) p = 2 * std::numbers::pi * random.uniform();
    start_ = 2 * std::numbers::pi * random.uniform();
  }

  /// T in (1) [s]
  double speed_up_s() const {
    if (kind_ == Kind::hall) return 6 * ramp_s;
    return kind_ == Kind::ring || kind_ == Kind::facade ? 2 * ramp_s : ramp_s;
  }

  /// (1)
  Jet phase(double t) const {
    const double T = speed_up_s();
    return ramp(t - stationary_s, T) + (-1.0) * ramp(t - stop_s_, T) + ramp(t - go_s_, T);
  }

  Kind kind_;
  std::array<double, 10> phase_{};
  double start_ = 0;
  double stop_s_ = std::numeric_limits<double>::infinity(), go_s_ = stop_s_;
};

}  // namespace plumbline::testing
