#pragma once
/// Numbers and series of a comparison as JSON: as many digits as mean something, NaN as null.

#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "format.hpp"
#include "plumbline/core/matrix.hpp"

inline nlohmann::json rounded(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  const double unit = std::pow(10, digits);
  return std::round(value * unit) / unit + 0.0;  // no -0
}

inline nlohmann::json rounded(const std::vector<double>& values, int digits) {
  nlohmann::json out = nlohmann::json::array();
  for (const double value : values) out.push_back(rounded(value, digits));
  return out;
}

/// Positions over time.
struct PositionSeries {
  std::vector<double> t, x, y, z;

  void add(double t_s, const plumbline::Vec<double, 3>& p) {
    t.push_back(t_s);
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
  nlohmann::json json() const {
    return {{"t", rounded(t, 4)}, {"x", rounded(x, 4)}, {"y", rounded(y, 4)}, {"z", rounded(z, 4)}};
  }
};

/// On one line; bytes that are no UTF-8 (of a file's name) are replaced.
inline std::string text_of(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Sixteen digits that other content would not have.
inline std::string fingerprint(std::string_view content) {
  return format("%016zx", std::hash<std::string_view>{}(content));
}
