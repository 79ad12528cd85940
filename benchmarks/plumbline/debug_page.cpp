#include "debug_page.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string_view>

#include "plumbline/io/output_file.hpp"
#include "svg_plot.hpp"

namespace pl = plumbline;

namespace {

constexpr const char *green = "#2a9d3a", *blue = "#1f6fc4", *red = "#c8322c", *amber = "#c79400", *gray = "#888";
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

const char* background_of(pl::HealthState state) {
  switch (state) {
    case pl::HealthState::initializing: return "#e4ecf7";
    case pl::HealthState::tracking: return "#ffffff";
    case pl::HealthState::degraded: return "#fdf0d0";
    case pl::HealthState::lost: return "#f8d4d4";
  }
  return "#ffffff";
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      default: out += c;
    }
  }
  return out;
}

constexpr std::string_view page_head = R"(<!doctype html>
<html lang="en"><meta charset="utf-8"><title>plumbline run</title>
<style>
body { font: 14px sans-serif; color: #333; margin: 16px; display: grid; grid-template-columns: minmax(0, 3fr) minmax(0, 4fr); gap: 16px; }
header { grid-column: 1 / 3; } h1 { font-size: 17px; margin: 0 0 4px; } pre { margin: 0; white-space: pre-wrap; }
aside { position: sticky; top: 8px; align-self: start; } img { width: 100%; } input { width: 100%; margin: 0; }
svg { width: 100%; display: block; margin-bottom: 4px; font: 11px sans-serif; cursor: crosshair; }
.grid { stroke: #ddd; stroke-width: .6; fill: none; } .curve { fill: none; stroke-width: 1.1; }
.cursor { stroke: #888; stroke-width: .8; } .title { font-weight: bold; } .end { text-anchor: end; } .middle { text-anchor: middle; }
.key span { padding: 1px 6px; border: 1px solid #ccc; margin-right: 6px; }
</style>
)";

/// `times` of all rows, `rows` that have a picture and their `files`; plots begin at `left` and are `width` wide.
constexpr std::string_view page_script = R"(
const image = document.getElementById('frame'), slider = document.getElementById('slider');
const t0 = times[0], span = Math.max(times[times.length - 1] - t0, 1e-9);
function show(k) {
  slider.value = k;
  image.src = files[k];
  const x = left + (times[rows[k]] - t0) / span * width;
  document.querySelectorAll('.cursor').forEach(c => c.setAttribute('transform', `translate(${x - left} 0)`));
}
slider.max = files.length - 1;
slider.oninput = () => show(+slider.value);
document.querySelectorAll('svg').forEach(svg => svg.onclick = click => {
  const box = svg.getBoundingClientRect();
  const t = t0 + ((click.clientX - box.left) / box.width * svg.viewBox.baseVal.width - left) / width * span;
  let k = 0;
  rows.forEach((row, i) => { if (Math.abs(times[row] - t) < Math.abs(times[rows[k]] - t)) k = i; });
  show(k);
});
document.onkeydown = key => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[key.key];
  if (!step) return;
  key.preventDefault();
  show(Math.min(Math.max(+slider.value + step, 0), files.length - 1));
};
show(0);
)";

std::vector<SvgPlot> plots_of(const DebugPage& page) {
  const auto column = [&](const std::string& name) { return page.frames.numbers(name); };
  std::vector<SvgPlot> out;
  for (const std::string& kind : page.kinds) {
    const auto count = [&](const char* state) { return column(kind + "_" + state); };
    out.push_back({kind,
                   {{"located", green, count("located")},
                    {"unlocated", blue, count("unlocated")},
                    {"rejected", red, count("rejected")},
                    {"lost", amber, count("lost")}}});
  }
  for (const std::string& kind : page.kinds) {
    const auto statistic = [&](const char* name) { return column(kind + "_innovation_" + name); };
    out.push_back({"innovation of " + kind + " [sigma], expected 1.18 and 2.15",
                   {{"90 %", gray, statistic("p90_sigma")}, {"median", blue, statistic("median_sigma")}}});
    out.push_back({"innovation of " + kind + " [px]",
                   {{"90 %", gray, statistic("p90_px")}, {"median", blue, statistic("median_px")}}});
  }

  out.push_back({"position [m]", {{"sigma", gray, column("sigma_position_m")}}});
  out.push_back({"rotation [deg]", {{"sigma", gray, column("sigma_rotation_deg")}}});
  if (!page.errors.empty()) {
    const std::vector<double> none(page.times.size(), unknown);
    Curve position{"error", red, none}, rotation{"error", red, none}, nees{"pose", blue, none};
    Curve low{"95 % of consistent ones", gray, none}, high{"", gray, none};
    for (const TruthError& each : page.errors) {
      const auto i = std::lower_bound(page.times.begin(), page.times.end(), each.t_ns) - page.times.begin();
      const auto row = static_cast<std::size_t>(i);
      position.y[row] = each.error.tail<3>().norm();
      rotation.y[row] = degrees * each.error.head<3>().norm();
      nees.y[row] = each.nees_pose;
      low.y[row] = 1.24;  // chi2 of six degrees of freedom
      high.y[row] = 14.45;
    }
    out[out.size() - 2].curves.push_back(position);
    out[out.size() - 1].curves.push_back(rotation);
    out.push_back({"NEES, aligned at the first pose; expected 6", {low, high, nees}});
  }
  if (page.has_imu) {
    const auto vector = [&](const char* title, const std::string& name) {
      out.push_back(
          {title,
           {{"x", red, column(name + "_x")}, {"y", green, column(name + "_y")}, {"z", blue, column(name + "_z")}}});
    };
    vector("velocity [m/s]", "velocity");
    vector("gyroscope bias [rad/s]", "bias_gyro");
    vector("its sigma [rad/s]", "sigma_bias_gyro");
    vector("accelerometer bias [m/s^2]", "bias_accel");
    vector("its sigma [m/s^2]", "sigma_bias_accel");
    out.push_back({"part of the time without a live IMU reading", {{"missing", red, column("imu_missing")}}});
  }
  out.push_back({"time [ms]",
                 {{"total", gray, column("total_ms")},
                  {"map", amber, column("map_ms")},
                  {"estimate", green, column("estimate_ms")},
                  {"track", blue, column("track_ms")}}});
  return out;
}

}  // namespace

void write_debug_page(const std::filesystem::path& html, const DebugPage& page) {
  pl::io::OutputFile file(html);
  std::ofstream& out = file.stream();
  std::vector<double> t_s;
  for (const pl::TimeNs t : page.times) t_s.push_back(pl::seconds_between(page.times.front(), t));
  std::vector<TimeSpan> background;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const std::string color = background_of(page.health[i]);
    if (background.empty() || background.back().color != color) background.push_back({t_s[i], t_s[i], color});
    background.back().end_s = t_s[std::min(i + 1, t_s.size() - 1)];
  }

  out << page_head << "<header><h1>" << escaped(page.title) << "</h1><pre>" << escaped(page.summary)
      << "</pre><p class=\"key\">";
  for (const auto state :
       {pl::HealthState::initializing, pl::HealthState::tracking, pl::HealthState::degraded, pl::HealthState::lost})
    out << "<span style=\"background:" << background_of(state) << "\">" << name_of(state) << "</span>";
  out << "click a plot, or use the arrow keys, to go to a frame</p></header>\n<aside>";
  if (!page.pictures.empty()) out << "<img id=\"frame\" alt=\"frame\"><input id=\"slider\" type=\"range\" min=\"0\">";
  if (page.has_trajectory) out << "<img src=\"trajectory.png\" alt=\"trajectory\">";
  out << "</aside>\n<main>\n";
  for (const SvgPlot& plot : plots_of(page)) out << svg_of(plot, t_s, background);
  out << "</main>\n<script>\nconst left = " << svg_left << ", width = " << svg_width << ";\nconst times = [";
  for (const double t : t_s) out << t << ',';
  out << "], rows = [";
  for (const DebugPage::Picture& picture : page.pictures) out << picture.row << ',';
  out << "], files = [";
  for (const DebugPage::Picture& picture : page.pictures) out << '\'' << picture.file << "',";
  out << "];\n" << (page.pictures.empty() ? "" : page_script) << "</script></html>\n";
  file.commit();
}
