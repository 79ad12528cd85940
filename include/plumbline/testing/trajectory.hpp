#pragma once
/// Smooth paths through the simulated scenes with exact derivatives.
///
/// Position and yaw, pitch, roll are sums of sinusoids of the phase s(t). It is constant up to t_0, gains speed during
/// T (C^5), and may be constant again from b to e; s = t for a camera shaken by hand:
///   s(t) = r(t - t_0) - r(t - b) + r(t - e),  r(t) = T F(t/T),
///   F' = 126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9 on [0, 1], then 1                                        (1)
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

namespace plumbline::testing {

/// A function of time with its first two derivatives.
struct Jet {
  double value = 0, d1 = 0, d2 = 0;

  friend Jet operator+(const Jet& a, const Jet& b) { return {a.value + b.value, a.d1 + b.d1, a.d2 + b.d2}; }
  friend Jet operator+(const Jet& a, double c) { return {a.value + c, a.d1, a.d2}; }
  friend Jet operator*(double c, const Jet& a) { return {c * a.value, c * a.d1, c * a.d2}; }
  friend Jet sin(const Jet& a) {
    const double s = std::sin(a.value), c = std::cos(a.value);
    return {s, c * a.d1, c * a.d2 - s * a.d1 * a.d1};
  }
  friend Jet cos(const Jet& a) { return sin(a + std::numbers::pi / 2); }
};

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
    return std::nullopt;
  }

  /// In the middle of the room, shaken by hand at 2 to 4 Hz from the first instant on: up to 5 rad/s and 20 m/s^2.
  static Trajectory shaken(std::uint64_t seed = 1) { return Trajectory(Kind::shaken, seed); }

  /// Slows down at begin_s, which takes a second (in the hall six), and continues from end_s.
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
  enum class Kind : std::uint8_t { room, corridor, walk, hall, shaken };

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

  /// (1)
  Jet phase(double t) const {
    const bool slow = kind_ == Kind::hall;
    const double T = slow ? 6 * ramp_s : ramp_s;
    return ramp(t - stationary_s, T) + (-1.0) * ramp(t - stop_s_, T) + ramp(t - go_s_, T);
  }
  static Jet ramp(double t, double T) {
    const double x = t / T;
    if (!(x > 0)) return {};
    if (x >= 1) return {T * (x - 0.5), 1, 0};
    const double x4 = x * x * x * x, x5 = x4 * x;
    return {T * x5 * x * (21 + x * (-60 + x * (67.5 + x * (-35 + x * 7)))),
            x5 * (126 + x * (-420 + x * (540 + x * (-315 + x * 70)))), 630 * x4 * std::pow(1 - x, 4) / T};
  }

  Kind kind_;
  std::array<double, 10> phase_{};
  double start_ = 0;
  double stop_s_ = std::numeric_limits<double>::infinity(), go_s_ = stop_s_;
};

}  // namespace plumbline::testing
