#include "starts_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "format.hpp"
#include "statistics.hpp"
#include "table_cells.hpp"

using nlohmann::json;

namespace {

constexpr double in_time_s = 2;  // of the first pose

/// Of all runs of a group.
struct InitializationSummary {
  std::size_t runs = 0, with_pose = 0, in_time = 0, tracking = 0, false_runs = 0, false_frames = 0;
  std::vector<double> pose_s;               ///< infinite of a run without a pose
  std::vector<double> scales, last_scales;  ///< where they are known

  explicit InitializationSummary(const json& group) {
    for (const json& run : group.at("runs")) {
      const double first_s =
          run.at("pose_s").is_null() ? std::numeric_limits<double>::infinity() : run.at("pose_s").get<double>();
      ++runs;
      pose_s.push_back(first_s);
      with_pose += std::isfinite(first_s);
      in_time += first_s <= in_time_s;
      tracking += !run.at("tracking_s").is_null();
      const auto frames = run.at("false_frames").get<std::size_t>();
      false_frames += frames;
      false_runs += frames > 0;
      if (!run.at("scale_error").is_null()) scales.push_back(run.at("scale_error").get<double>());
      if (!run.at("last_scale_error").is_null()) last_scales.push_back(run.at("last_scale_error").get<double>());
    }
  }
};

double largest_of(const std::vector<double>& values) {
  return values.empty() ? std::nan("") : *std::max_element(values.begin(), values.end());
}

std::string seconds(double value) {
  return std::isnan(value) ? "-" : std::isinf(value) ? "never" : format("%.2f s", value);
}

std::string percents(const std::vector<double>& scales) {
  return scales.empty() ? "-" : format("%.1f (%.1f) %%", 100 * median(scales), 100 * largest_of(scales));
}

void print_initialization_row(std::ostream& out, const json& group) {
  const InitializationSummary summary(group);
  out << "| `" << group.at("configuration").get<std::string>() << "` | " << seconds(median(summary.pose_s)) << " ("
      << seconds(largest_of(summary.pose_s)) << ") | " << format("%zu of %zu | ", summary.in_time, summary.runs)
      << format("%zu of %zu | ", summary.tracking, summary.runs) << percents(summary.scales) << " | "
      << percents(summary.last_scales) << " | " << summary.false_frames
      << (summary.false_frames > 0 ? " in " + counted(summary.false_runs, "run") : "") << " |\n";
}

}  // namespace

void print_summary(std::ostream& out, const json& group) {
  const InitializationSummary summary(group);
  out << format(
      "%zu runs: %zu with a pose (median %s), %zu tracking, %zu falsely; scale error %s at the first tracking "
      "frame, %s in the last two seconds\n",
      summary.runs, summary.with_pose, seconds(median(summary.pose_s)).c_str(), summary.tracking, summary.false_runs,
      percents(summary.scales).c_str(), percents(summary.last_scales).c_str());
}

void print_initialization(std::ostream& out, const json& groups) {
  std::vector<std::string> datasets;
  for (const json& group : groups) {
    const auto name = group.at("dataset").get<std::string>();
    if (std::find(datasets.begin(), datasets.end(), name) == datasets.end()) datasets.push_back(name);
  }
  for (const std::string& dataset : datasets) {
    const auto first =
        std::find_if(groups.begin(), groups.end(), [&](const json& g) { return g.at("dataset") == dataset; });
    out << format("`%s`: a run of %g s every %g s.\n\n", dataset.c_str(), first->at("duration_s").get<double>(),
                  first->at("every_s").get<double>())
        << "| configuration | first pose | within 2 s | tracking | scale error at tracking | scale error at the end | "
           "false frames |\n| --- | --- | --- | --- | --- | --- | --- |\n";
    for (const json& group : groups)
      if (group.at("dataset") == dataset) print_initialization_row(out, group);
    out << '\n';
  }
  out << wrapped(
      "First pose: time after the first image of a run, median (worst), of the first metric pose, also one of "
      "uncertain scale. Tracking: runs that reach the state `tracking`. Scale error: |1 - scale| of a Sim(3) alignment "
      "with the truth, median (worst), over the two seconds after the first `tracking` frame and over the last two "
      "seconds. False frames: `tracking` frames whose error since the first pose exceeds 3 sigma of the published "
      "covariance, in position or rotation.");
}
