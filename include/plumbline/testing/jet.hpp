#pragma once
/// A function of time with its first two derivatives (second-order Taylor arithmetic), and two smooth functions.
///
///   F' = 126 x^5 - 420 x^6 + 540 x^7 - 315 x^8 + 70 x^9 on [0, 1], 0 before, 1 after                             (1)
///   ramp(t, T) = T F(t/T): slope from 0 to 1 during T;   step(t, T) = F'(t/T): value from 0 to 1 during T

#include <cmath>
#include <numbers>

namespace plumbline::testing {

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

/// f(a), where f holds the derivatives with respect to a.
inline Jet chain(const Jet& f, const Jet& a) { return {f.value, f.d1 * a.d1, f.d2 * a.d1 * a.d1 + f.d1 * a.d2}; }

inline Jet ramp(double t, double T) {
  const double x = t / T;
  if (!(x > 0)) return {};
  if (x >= 1) return {T * (x - 0.5), 1, 0};
  const double x4 = x * x * x * x, x5 = x4 * x;
  return {T * x5 * x * (21 + x * (-60 + x * (67.5 + x * (-35 + x * 7)))),
          x5 * (126 + x * (-420 + x * (540 + x * (-315 + x * 70)))), 630 * x4 * std::pow(1 - x, 4) / T};
}

inline Jet step(double t, double T) {
  const double x = t / T;
  if (!(x > 0)) return {};
  if (x >= 1) return {1, 0, 0};
  const Jet slope = ramp(t, T);
  return {slope.d1, slope.d2, 2520 * std::pow(x * (1 - x), 3) * (1 - 2 * x) / (T * T)};
}

}  // namespace plumbline::testing
