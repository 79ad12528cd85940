#include "svg_plot.hpp"

#include <algorithm>
#include <cmath>

#include "axis.hpp"
#include "format.hpp"

namespace {

constexpr double total_width = 900, height = 150, top = 22, bottom = 18;  // [px]

struct Range {
  double low = 0, high = 1;
};

/// From zero, if nothing is negative, to the largest value that is no outlier.
Range range_of(const std::vector<Curve>& curves) {
  std::vector<double> sizes;
  double low = 0, high = 0;
  for (const Curve& curve : curves)
    for (const double y : curve.y) {
      if (!std::isfinite(y)) continue;
      low = std::min(low, y);
      high = std::max(high, y);
      sizes.push_back(std::abs(y));
    }
  if (sizes.empty() || (low == 0 && high == 0)) return {};
  const auto rank = sizes.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), rank, sizes.end());
  if (const double limit = 3 * *rank; limit > 0) {
    low = std::max(low, -limit);
    high = std::min(high, limit);
  }
  const double margin = 0.05 * (high - low);
  return {low < 0 ? low - margin : 0, high + margin};
}

}  // namespace

std::string svg_of(const SvgPlot& plot, const std::vector<double>& t_s, const std::vector<TimeSpan>& background) {
  const double t0 = t_s.front(), duration = std::max(t_s.back() - t0, 1e-9);
  const Range range = range_of(plot.curves);
  const auto x_of = [&](double t) { return svg_left + (t - t0) / duration * svg_width; };
  const auto y_of = [&](double y) {
    const double part = (std::clamp(y, range.low, range.high) - range.low) / (range.high - range.low);
    return height - bottom - part * (height - top - bottom);
  };

  std::string out = format("<svg viewBox=\"0 0 %g %g\">\n", total_width, height);
  for (const TimeSpan& span : background)
    out += format("<rect x=\"%.1f\" y=\"%g\" width=\"%.1f\" height=\"%g\" fill=\"%s\"/>\n", x_of(span.begin_s), top,
                  std::max(1.0, x_of(span.end_s) - x_of(span.begin_s)), height - top - bottom, span.color.c_str());
  const double step_y = grid_step(range.high - range.low, 4), step_t = grid_step(duration, 12);
  for (double y = std::ceil(range.low / step_y) * step_y; y <= range.high; y += step_y)
    out += format("<path d=\"M%g %.1fh%g\" class=\"grid\"/><text x=\"%g\" y=\"%.1f\" class=\"end\">%s</text>\n",
                  svg_left, y_of(y), svg_width, svg_left - 5, y_of(y) + 4, grid_label(y, step_y).c_str());
  for (double t = std::ceil(t0 / step_t) * step_t; t <= t_s.back(); t += step_t)
    out += format("<path d=\"M%.1f %gv%g\" class=\"grid\"/><text x=\"%.1f\" y=\"%g\" class=\"middle\">%s</text>\n",
                  x_of(t), top, height - top - bottom, x_of(t), height - 5, grid_label(t, step_t).c_str());

  out += format("<text x=\"%g\" y=\"14\" class=\"title\">%s</text>\n", svg_left, plot.title.c_str());
  double x_legend = svg_left + svg_width;
  for (auto curve = plot.curves.rbegin(); curve != plot.curves.rend(); ++curve) {
    out += format("<text x=\"%.1f\" y=\"14\" class=\"end\" style=\"fill:%s\">%s</text>\n", x_legend,
                  curve->color.c_str(), curve->name.c_str());
    x_legend -= 12 + 6.2 * static_cast<double>(curve->name.size());
  }
  for (const Curve& curve : plot.curves) {
    out += "<path class=\"curve\" style=\"stroke:" + curve.color + "\" d=\"";
    bool pen_down = false;
    for (std::size_t i = 0; i < curve.y.size(); ++i) {
      const bool known = std::isfinite(curve.y[i]);
      // A value between two unknown ones is a dash, not nothing.
      if (known) out += format(pen_down ? "L%.1f %.1f" : "M%.1f %.1fh.1", x_of(t_s[i]), y_of(curve.y[i]));
      pen_down = known;
    }
    out += "\"/>\n";
  }
  return out + format("<path class=\"cursor\" d=\"M%g %gv%g\"/></svg>\n", svg_left, top, height - top - bottom);
}
