#pragma once
/// Figures of a list of numbers; NaN of none.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

/// Middle, or mean of the two in the middle.
inline double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

/// The smallest value that is not exceeded by this share of them.
inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}
