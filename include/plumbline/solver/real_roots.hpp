#pragma once
/// Real roots of a polynomial c0 + c1 x + ... + cN x^N.                                     docs/math/solver.md (20)
///
/// Between two neighboring roots of its derivative a polynomial is monotone and has at most one root: from the linear
/// (N-1)th derivative up, each level's roots divide the interval for the next. Newton's method finds them, kept between
/// ends of different sign by bisection. Roots where the sign does not change may be missed.

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"

namespace plumbline {

namespace real_roots_detail {

/// Value and derivative at x of the polynomial of this degree.
template <std::floating_point S>
struct Horner {
  S value, derivative = S(0);
  Horner(const S* c, int degree, S x) : value(c[degree]) {
    for (int k = degree - 1; k >= 0; --k) {
      derivative = derivative * x + value;
      value = value * x + c[k];
    }
  }
};

/// The root between a and b, where the signs of the polynomial differ; it is negative at a.
template <std::floating_point S>
S root_between(const S* c, int degree, S a, S b) {
  S x = (a + b) / 2;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Horner<S> p(c, degree, x);
    if (p.value == S(0)) return x;
    (p.value < S(0) ? a : b) = x;
    S next = x - p.value / p.derivative;
    const bool inside = (next > a && next < b) || (next > b && next < a);  // false for NaN
    if (!inside) next = (a + b) / 2;
    if (next == x || next == a || next == b) return next;
    x = next;
  }
  return x;
}

}  // namespace real_roots_detail

/// Those in (low, high), ascending; none when a coefficient is not finite.
template <int N, std::floating_point S>
FixedVector<S, N> real_roots(const std::array<S, N + 1>& c, S low, S high) {
  using namespace real_roots_detail;
  FixedVector<S, N> roots;
  for (int degree = 1; degree <= N; ++degree) {
    std::array<S, N + 1> derivative;  // the (N - degree)th one, k! left out
    for (int k = 0; k <= degree; ++k) {
      S binomial = 1;
      for (int m = 1; m <= N - degree; ++m) binomial = binomial * S(k + m) / S(m);
      derivative[std::size_t(k)] = binomial * c[std::size_t(k + N - degree)];
    }
    FixedVector<S, N> next;
    S a = low, value_a = Horner<S>(derivative.data(), degree, a).value;
    for (std::size_t k = 0; k <= roots.size(); ++k) {
      const S b = k < roots.size() ? roots[k] : high, value_b = Horner<S>(derivative.data(), degree, b).value;
      if (value_a < S(0) && value_b > S(0)) next.push_back(root_between(derivative.data(), degree, a, b));
      if (value_a > S(0) && value_b < S(0)) next.push_back(root_between(derivative.data(), degree, b, a));
      a = b;
      value_a = value_b;
    }
    roots = next;
  }
  return roots;
}

}  // namespace plumbline
