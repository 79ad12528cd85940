#pragma once
/// How far a distortion polynomial can be inverted: the first positive root of its derivative.  docs/math/camera.md (5)

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

namespace plumbline {

/// The smallest root of f(q) = 1 + c[0] q + c[1] q^2 + ... in (0, q_max], or q_max when f stays positive there.
///
/// The roots of each derivative of f separate those of the one below, so bisection between them misses none.
template <std::floating_point S, std::size_t N>
S monotone_limit(const std::array<S, N>& c, S q_max) {
  // f^(k)(q) / k! = sum over i >= k of binomial(i, k) a_i q^(i-k), a = (1, c)
  const auto derivative = [&](std::size_t k, S q) {
    S value = 0;
    for (std::size_t i = N; i + 1 > k; --i) {
      S binomial = 1;
      for (std::size_t j = 0; j < k; ++j) binomial = binomial * S(i - j) / S(j + 1);
      value = value * q + binomial * (i == 0 ? S(1) : c[i - 1]);
      if (i == 0) break;
    }
    return value;
  };
  std::array<S, N + 2> separators{S(0), q_max};  // 0, the roots of the derivative above, q_max
  std::size_t count = 2;
  for (std::size_t k = N; k-- > 0;) {
    std::array<S, N + 2> next{S(0)};
    std::size_t next_count = 1;
    for (std::size_t i = 0; i + 1 < count; ++i) {
      S low = separators[i], high = separators[i + 1];
      const bool low_positive = derivative(k, low) > 0;
      if (low_positive == (derivative(k, high) > 0)) continue;
      for (int step = 0; step < 60; ++step) {
        const S middle = low + (high - low) / 2;
        ((derivative(k, middle) > 0) == low_positive ? low : high) = middle;
      }
      next[next_count++] = low;
    }
    next[next_count++] = q_max;
    separators = next;
    count = next_count;
  }
  return separators[1];
}

}  // namespace plumbline
