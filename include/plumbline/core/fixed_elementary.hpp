#pragma once
/// Elementary functions that give the same bits on every machine with IEEE 754 arithmetic: of + - * / and square roots
/// alone, which are exactly rounded, and of frexp, ldexp, fmod and rounding, which are exact. Functions of a C library
/// differ in the last bit from library to library. Compile with -ffp-contract=off.
///
/// In double within 4 units in the last place, angles up to 1e5; in float computed in double and rounded. NaN gives
/// NaN. Series:
///   sin x = x - x^3/3! + ..., |x| <= pi/4;  exp x = 1 + x + x^2/2! + ..., |x| <= ln 2 / 2
///   log m = 2 (f + f^3/3 + ...), f = (m-1)/(m+1);  atan t = t - t^3/3 + ..., |t| <= tan(pi/16)

#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>
#include <type_traits>

namespace plumbline::fixed_elementary {

namespace detail {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                        infinity = std::numeric_limits<double>::infinity();

/// An angle as a multiple of pi/2 and a rest within pi/4.
struct Reduced {
  double rest;
  int quadrant;  ///< 0 to 3
};
inline Reduced reduced(double x) {
  if (!(std::abs(x) < 1e5)) x = std::fmod(x, 2 * std::numbers::pi);  // NaN for NaN and infinity
  if (std::isnan(x)) return {nan, 0};
  const double k = std::floor(x * (2 / std::numbers::pi) + 0.5);
  const double rest = ((x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a6p-34) - k * 0x1.3198a2e037073p-69;
  return {rest, static_cast<int>(k) & 3};
}
/// first (1 - z/((n-1) n) (1 - ...)), the series of sine and cosine up to the power `last`.
inline double alternating(double first, double z, int begin, int last) {
  double sum = 1;
  for (int n = last; n >= begin; n -= 2) sum = 1 - z / ((n - 1) * n) * sum;
  return first * sum;
}
inline double sin_in_quadrant(const Reduced& x, int quadrant) {
  const double z = x.rest * x.rest;
  const double y = (quadrant & 1) != 0 ? alternating(1, z, 2, 18) : alternating(x.rest, z, 3, 19);
  return (quadrant & 2) != 0 ? -y : y;
}
/// f + f^3 / 3 + f^5 / 5 + ..., with alternating signs for sign = -1; |f| < 0.2.
inline double odd_series(double f, double sign) {
  const double z = sign * f * f;
  double sum = 0;
  for (int n = 25; n >= 3; n -= 2) sum = z * (1.0 / n + sum);
  return f + f * sum;
}
inline double sin(double x) {
  const Reduced r = reduced(x);
  return sin_in_quadrant(r, r.quadrant);
}
inline double cos(double x) {
  const Reduced r = reduced(x);
  return sin_in_quadrant(r, r.quadrant + 1);
}
inline double tan(double x) { return sin(x) / cos(x); }

inline double exp(double x) {
  if (x > 710) return infinity;
  if (x < -746) return 0;
  if (std::isnan(x)) return nan;
  const double k = std::floor(x * (1 / std::numbers::ln2) + 0.5);
  const double r = (x - k * 0x1.62e42fefa2p-1) - k * 0x1.9ef35793c7673p-41;
  double sum = 1;
  for (int n = 14; n >= 2; --n) sum = 1 + r / n * sum;
  return std::ldexp(1 + r * sum, static_cast<int>(k));
}
inline double log(double x) {
  if (!(x > 0)) return x == 0 ? -infinity : nan;
  if (x == infinity) return x;
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < std::numbers::sqrt2 / 2) {
    m *= 2;
    --e;
  }
  return e * 0x1.62e42fefa2p-1 + (2 * odd_series((m - 1) / (m + 1), 1) + e * 0x1.9ef35793c7673p-41);
}
inline double log1p(double x) { return std::abs(x) < 0.4 ? 2 * odd_series(x / (2 + x), 1) : log(1 + x); }

inline double atan2(double y, double x) {
  const double a = std::abs(y), b = std::abs(x);
  const bool steep = a > b;
  const double low = steep ? b : a, high = steep ? a : b;
  double t = low / high;
  if (high == 0 && low == 0) t = 0;
  if (low == infinity) t = 1;
  const bool above = t > std::numbers::sqrt2 - 1;  // tan(pi/8)
  if (above) t = (t - 1) / (t + 1);
  const double half = t / (1 + std::sqrt(1 + t * t));  // tan of half the angle
  double angle = 2 * odd_series(half, -1);
  if (above) angle += std::numbers::pi / 4;
  if (steep) angle = std::numbers::pi / 2 - angle;
  if (std::signbit(x)) angle = std::numbers::pi - angle;
  return std::copysign(angle, y);
}
inline double acos(double x) { return 2 * atan2(std::sqrt(1 - x), std::sqrt(1 + x)); }

inline double cbrt(double x) {
  if (!(std::abs(x) > 0 && std::abs(x) < infinity)) return x;
  int e = 0;
  double m = std::frexp(std::abs(x), &e);
  for (; e % 3 != 0; --e) m *= 2;
  double y = 1;
  for (int i = 0; i < 8; ++i) y -= (y - m / (y * y)) / 3;  // Newton's method, m in [0.5, 4)
  return std::copysign(std::ldexp(y, e / 3), x);
}
inline double hypot(double a, double b) {
  a = std::abs(a);
  b = std::abs(b);
  if (a == infinity || b == infinity) return infinity;
  const double high = a > b ? a : b, low = a > b ? b : a;
  if (!(high > 0)) return high + low;
  const double t = low / high;
  return high * std::sqrt(1 + t * t);
}

}  // namespace detail

template <std::floating_point S>
S sin(S x) {
  return static_cast<S>(detail::sin(x));
}
template <std::floating_point S>
S cos(S x) {
  return static_cast<S>(detail::cos(x));
}
template <std::floating_point S>
S tan(S x) {
  return static_cast<S>(detail::tan(x));
}
template <std::floating_point S>
S exp(S x) {
  return static_cast<S>(detail::exp(x));
}
template <std::floating_point S>
S log(S x) {
  return static_cast<S>(detail::log(x));
}
template <std::floating_point S>
S log1p(S x) {
  return static_cast<S>(detail::log1p(x));
}
template <std::floating_point S>
S acos(S x) {
  return static_cast<S>(detail::acos(x));
}
template <std::floating_point S>
S cbrt(S x) {
  return static_cast<S>(detail::cbrt(x));
}
template <std::floating_point A, std::floating_point B>
std::common_type_t<A, B> atan2(A y, B x) {
  return static_cast<std::common_type_t<A, B>>(detail::atan2(y, x));
}
template <std::floating_point A, std::floating_point B>
std::common_type_t<A, B> hypot(A a, B b) {
  return static_cast<std::common_type_t<A, B>>(detail::hypot(a, b));
}

/// x^n for n >= 0.
template <std::floating_point S>
S pow(S x, int n) {
  S out = 1;
  for (; n > 0; --n) out *= x;
  return out;
}

}  // namespace plumbline::fixed_elementary
