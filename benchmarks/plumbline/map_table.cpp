#include "map_table.hpp"

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

constexpr double infinite_value = std::numeric_limits<double>::infinity();

/// Of a member of each run; infinite where it is null.
std::vector<double> values_in_group(const json& group, const char* member) {
  std::vector<double> out;
  for (const json& run : group.at("runs"))
    out.push_back(run.at(member).is_null() ? infinite_value : run.at(member).get<double>());
  return out;
}

/// Of the runs that have the member.
std::vector<double> known_values_in_group(const json& group, const char* member) {
  std::vector<double> out = values_in_group(group, member);
  std::erase_if(out, [](double value) { return std::isinf(value); });
  return out;
}

/// "median (worst)", each as the function writes it.
template <class Text>
std::string median_and_worst(const std::vector<double>& values, const Text& text) {
  if (values.empty()) return "-";
  return text(median(values)) + " (" + text(*std::max_element(values.begin(), values.end())) + ")";
}
std::string meters_cell(double value) {
  return std::isinf(value) ? "failed" : format("%.*f", value < 0.1 ? 4 : value < 10 ? 3 : 1, value);
}
std::string percent_cell(double value) { return std::isinf(value) ? "failed" : format("%.2f %%", value); }
std::string seconds_cell(double value) { return std::isinf(value) ? "never" : format("%.2f s", value); }

std::string name_of_group(const json& group) {
  return "`" + group.at("configuration").get<std::string>() + (group.at("with_map").get<bool>() ? " --map" : "") + "`";
}

/// A table for each stretch of groups with the same heading, and what its columns are.
template <class HeadingOf, class RowOf>
void print_group_tables(std::ostream& out, const json& groups, const std::vector<std::string>& columns,
                        const HeadingOf& heading_of, const RowOf& row_of, const std::string& legend) {
  if (groups.empty()) {
    out << "No runs.\n";
    return;
  }
  std::string before;
  for (const json& group : groups) {
    if (const std::string heading = heading_of(group); heading != before) {
      out << (before.empty() ? "" : "\n") << heading << "\n\n| configuration |";
      for (const std::string& column : columns) out << ' ' << column << " |";
      out << "\n| --- |";
      for (std::size_t i = 0; i < columns.size(); ++i) out << " --- |";
      out << '\n';
      before = heading;
    }
    out << "| " << name_of_group(group) << " | " << row_of(group) << " |\n";
  }
  out << '\n' << wrapped(legend);
}

std::string runs_in_group(const json& group) { return counted(group.at("runs").size(), "run"); }

std::string scene_of_group(const json& group) {
  return format("`%s`, seed %d", group.at("dataset").get<std::string>().c_str(), group.at("seed").get<int>());
}

std::string row_of_laps(const json& group) {
  const bool with_map = group.at("with_map").get<bool>();
  std::vector<double> end, coverage;
  for (const json& run : group.at("runs")) {
    end.push_back(run.at("end_m").is_null() ? infinite_value
                                            : 100 * run.at("end_m").get<double>() / run.at("path_m").get<double>());
    coverage.push_back(run.at("poses").get<double>() / run.at("frames").get<double>());
  }
  std::string row = median_and_worst(values_in_group(group, "ate_m"), meters_cell);
  for (std::size_t lap = 0; lap < group.at("laps").get<std::size_t>(); ++lap) {
    std::vector<double> errors;
    for (const json& run : group.at("runs")) {
      const json& error = run.at("lap_m").at(lap);
      errors.push_back(error.is_null() ? infinite_value : error.get<double>());
    }
    row += " | " + median_and_worst(errors, meters_cell);
  }
  return row + " | " + (with_map ? median_and_worst(values_in_group(group, "final_m"), meters_cell) : "-") + " | " +
         median_and_worst(end, percent_cell) + " | " +
         (with_map ? format("%g", median(values_in_group(group, "loops"))) : "-") + " | " +
         percent(*std::min_element(coverage.begin(), coverage.end()));
}

/// Medians of error and sigma of the runs that have them.
std::string error_and_sigma(const json& group, const char* error, const char* sigma) {
  const std::vector<double> errors = known_values_in_group(group, error), sigmas = known_values_in_group(group, sigma);
  return errors.empty() ? "-" : meters_cell(median(errors)) + ", " + meters_cell(median(sigmas));
}

std::string row_of_lost(const json& group) {
  const std::vector<double> found = values_in_group(group, "found_s");
  const auto soon = std::count_if(found.begin(), found.end(), [](double s) { return s <= 1; });
  std::size_t poses = 0, false_frames = 0;
  for (const json& run : group.at("runs")) {
    poses += run.at("poses").get<std::size_t>();
    false_frames += run.at("false_frames").get<std::size_t>();
  }
  return median_and_worst(values_in_group(group, "within_s"), seconds_cell) + " | " +
         error_and_sigma(group, "within_error_m", "within_sigma_m") + " | " + median_and_worst(found, seconds_cell) +
         " | " + error_and_sigma(group, "found_error_m", "found_sigma_m") + " | " +
         (found.empty() ? "-" : percent(double(soon) / double(found.size())) + format(" (%d)", int(soon))) + " | " +
         format("%zu of %zu", false_frames, poses);
}

std::string row_of_recording(const json& group) {
  const bool with_map = group.at("with_map").get<bool>();
  const std::vector<double> ate = values_in_group(group, "ate_m"), coverage = values_in_group(group, "coverage");
  const auto failed = std::count(ate.begin(), ate.end(), infinite_value);
  return median_and_worst(ate, meters_cell) + " | " +
         (with_map ? median_and_worst(values_in_group(group, "final_m"), meters_cell) : "-") + " | " +
         (with_map ? format("%g", median(known_values_in_group(group, "loops"))) : "-") + " | " +
         percent(*std::min_element(coverage.begin(), coverage.end())) + " | " +
         format("%d of %zu", int(failed), ate.size());
}

}  // namespace

void print_map_laps(std::ostream& out, const json& map) {
  print_group_tables(
      out, map.at("laps"), {"ATE [m]", "lap 1", "lap 2", "lap 3", "final", "end of path", "loops", "coverage"},
      [](const json& group) {
        return scene_of_group(group) +
               format(": %zu laps, %s.", group.at("laps").get<std::size_t>(), runs_in_group(group).c_str());
      },
      row_of_laps,
      "Cells: median (worst) of runs that begin half a second apart. ATE: root mean square of the position error of "
      "causal poses after one alignment over the whole run (sim3 for a camera alone, posyaw with an IMU, se3 with "
      "depth). Laps: the same error in each third of the recording. Final: ATE of the poses as the map has them at the "
      "end of the run. End of path: error of the last position relative to the first pose, of the true length of the "
      "path; for a camera alone in the unit of the alignment. Loops: median. Coverage: frames with a pose; the lowest "
      "of the runs.");
}

void print_map_lost(std::ostream& out, const json& map) {
  print_group_tables(
      out, map.at("lost"),
      {"within 3 sigma", "error, sigma [m]", "found", "error, sigma [m]", "within 1 s", "false frames"},
      [](const json& group) {
        return scene_of_group(group) +
               format(": black for %g s, %s.", group.at("black_s").get<double>(), runs_in_group(group).c_str());
      },
      row_of_lost,
      "Cells: median (worst) of runs whose images are black at different times of the last lap, of which at least 1.5 "
      "s "
      "follow. Seconds count from the first image that is not black. Within 3 sigma: until the first pose whose "
      "position error is within 3 sigma "
      "(99.7 %) of the published covariance; error: of this position, sigma: of the length of its three components, as "
      "published, medians of the runs that have such a pose. The map, or without one the world, is aligned with the "
      "truth by the poses before the black images. " +
          format("Found: the same of the first pose that is within 3 sigma and within %g m of the truth. ", found_m) +
          "Within 1 s: share (number) of the runs that have found it so soon. False frames: `tracking` frames outside "
          "of 3 sigma in position, of all poses after the black images, in the sum of the runs.");
}

void print_map_recordings(std::ostream& out, const json& map) {
  print_group_tables(
      out, map.at("recordings"), {"ATE [m]", "final", "loops", "coverage", "failed runs"},
      [](const json& group) {
        return format("`%s`: %s.", group.at("dataset").get<std::string>().c_str(), runs_in_group(group).c_str());
      },
      row_of_recording,
      "Cells: median (worst) of runs that begin one frame apart. ATE and final as above; coverage: frames with a pose, "
      "of those with truth, the lowest of the runs. A failed run counts as an infinite error.");
}

void print_map(std::ostream& out, const json& map) {
  bool is_first = true;
  const auto print = [&](const char* member, const auto& table) {
    if (map.at(member).empty()) return;
    out << (is_first ? "" : "\n");
    table(out, map);
    is_first = false;
  };
  print("laps", print_map_laps);
  print("lost", print_map_lost);
  print("recordings", print_map_recordings);
}
