#pragma once
/// Curves over time as SVG, to be set into a page.

#include <string>
#include <vector>

struct Curve {
  std::string name, color;  ///< as CSS has it
  std::vector<double> y;    ///< one for each time; the curve is broken at NaN
};

struct SvgPlot {
  std::string title;  ///< with the unit
  std::vector<Curve> curves;
};

/// Colours behind all plots, and what they mean.
struct TimeSpan {
  double begin_s, end_s;
  std::string color;
};

/// Every plot has the same time axis: class "cursor" is a vertical line that the page may move to
/// x = svg_left + (t - t.front())/(t.back() - t.front()) svg_width. What exceeds three times the 98th percentile is cut
/// off.
inline constexpr double svg_left = 60, svg_width = 820;  // [px]
std::string svg_of(const SvgPlot& plot, const std::vector<double>& t_s, const std::vector<TimeSpan>& background);
