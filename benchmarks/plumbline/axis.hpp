#pragma once
/// The grid of a plot: round steps and their labels.

#include <algorithm>
#include <cmath>
#include <string>

#include "format.hpp"

/// 1, 2 or 5 times a power of ten, at most `parts` of them in the range.
inline double grid_step(double range, double parts) {
  const double raw = range / parts, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= raw) return factor * power;
  return 10 * power;
}

inline std::string grid_label(double value, double step) {
  return format("%.*f", std::max(0, -static_cast<int>(std::floor(std::log10(step)))),
                std::abs(value) < step / 2 ? 0.0 : value);
}
