#pragma once
/// The unit of the time stamps of a file, recognized where they are Unix times.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "plumbline/io/text.hpp"

namespace plumbline::io {

/// The unit in which the first time stamps are Unix times of the years 1985 to 2128 and follow each other within
/// 10 us to 3 s; `expected` where that holds in it too, or in none.
inline TimeUnit unit_of_times(const std::filesystem::path& file, TimeUnit expected) {
  constexpr std::size_t looked_at = 100;
  std::vector<double> times;
  for (RowReader row(file); times.size() < looked_at && row.next();)
    if (const std::optional<double> t = parse_finite(row[0])) times.push_back(*t);
  if (times.size() < 2) return expected;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  const auto fits = [&](TimeUnit unit) {
    const double per_second = std::pow(1e3, static_cast<int>(unit));
    const double first_s = times.front() / per_second, interval_s = *middle / per_second;
    return first_s > 5e8 && first_s < 5e9 && interval_s > 1e-5 && interval_s < 3;
  };
  if (fits(expected)) return expected;
  for (const TimeUnit unit : {TimeUnit::seconds, TimeUnit::milliseconds, TimeUnit::microseconds, TimeUnit::nanoseconds})
    if (fits(unit)) return unit;
  return expected;
}

}  // namespace plumbline::io
