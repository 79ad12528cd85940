#include "compare_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "format.hpp"
#include "statistics.hpp"
#include "table_cells.hpp"

using nlohmann::json;

namespace {

/// Of the runs of one configuration on one data set; no ATE is printed without the rest.
struct Summary {
  std::size_t runs = 0, failed = 0;
  std::string alignment;
  std::vector<double> ate_m;                              ///< infinite of a failed run
  std::vector<double> coverage;                           ///< zero of a failed run
  std::vector<double> rpe_m, rpe_deg;                     ///< within a second, of the runs that have it
  std::vector<double> ms;                                 ///< of the processor, medians of the runs that had frames
  std::vector<double> wall_ms, wall_p99_ms, wall_max_ms;  ///< medians, 99th percentiles and longest, of the same runs
  std::vector<double> final_ate_m, loops;                 ///< of the runs with a map
  std::map<std::string, std::vector<double>> map_ms;      ///< means of the stages of the map, of the same
  std::map<std::string, double> longest_map_ms;

  double median_ate_m() const { return median(ate_m); }
  double worst_ate_m() const { return *std::max_element(ate_m.begin(), ate_m.end()); }
  double lowest_coverage() const { return *std::min_element(coverage.begin(), coverage.end()); }
};

Summary summary_of(const json& comparison, const json& configuration, const json& dataset, bool with_map) {
  Summary out;
  for (const json& run : comparison.at("runs")) {
    if (run.at("configuration") != configuration.at("name") || run.at("dataset") != dataset.at("name") ||
        run.value("with_map", false) != with_map)
      continue;
    const bool is_ok = run.at("status") == "ok";
    ++out.runs;
    out.failed += !is_ok;
    out.alignment = run.at("alignment").get<std::string>();
    out.ate_m.push_back(is_ok ? run.at("ate").at("rmse").get<double>() : std::numeric_limits<double>::infinity());
    out.coverage.push_back(is_ok ? run.at("coverage").get<double>() : 0);
    const auto add = [](std::vector<double>& values, const json& object, const char* member) {
      if (object.is_object() && !object.at(member).is_null()) values.push_back(object.at(member).get<double>());
    };
    add(out.rpe_m, run.at("rpe_1s"), "translation_rmse");
    add(out.rpe_deg, run.at("rpe_1s"), "rotation_rmse_deg");
    const json& times = run.at("time_ms");
    add(out.ms, times, "cpu_median");
    add(out.wall_ms, times, "median");
    add(out.wall_p99_ms, times, "p99");
    add(out.wall_max_ms, times, "max");
    if (run.contains("map_counts")) add(out.loops, run.at("map_counts"), "loops");
    if (run.contains("ate_final")) add(out.final_ate_m, run.at("ate_final"), "rmse");
    if (!times.is_object() || !times.contains("map")) continue;
    for (const auto& [stage, ms] : times.at("map").items()) {
      add(out.map_ms[stage], ms, "mean");
      if (!ms.at("max").is_null())
        out.longest_map_ms[stage] = std::max(out.longest_map_ms[stage], ms.at("max").get<double>());
    }
  }
  return out;
}

std::string text_of_machine_and_processes(const json& machine, const json& processes) {
  const auto runs = processes.get<std::size_t>();
  return text_of_machine(machine) + "; " +
         (runs == 1 ? "one run at a time" : format("up to %zu runs side by side", runs));
}

/// Every machine that took part.
std::string text_of_machines(const json& comparison) {
  std::set<std::string> texts;
  for (const json& run : comparison.at("runs"))
    texts.insert(text_of_machine_and_processes(run.value("machine", comparison.at("machine")),
                                               run.value("processes", comparison.at("processes"))));
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : "; and ") + text;
  return out;
}

std::string text_of_runs(const json& comparison) {
  std::size_t most = 0;
  for (const json& run : comparison.at("runs")) most = std::max(most, run.at("repeat").get<std::size_t>() + 1);
  return most == 1 ? "one run" : format("%zu runs that begin one frame apart", most);
}

constexpr const char* alignments = "(se3: rigid, posyaw: position and heading, sim3: with scale)";

std::string legend_of(const json& comparison) {
  return std::string("ATE: root mean square of the position error after alignment ") + alignments +
         ", median and worst of " + text_of_runs(comparison) +
         ", of causal poses: each is the one published with its frame. Coverage: frames with such a pose, of those "
         "with truth; the lowest of the runs. ms: of the processor, median of the frames. " +
         text_of_machines(comparison) + ".";
}

void print_heading(std::ostream& out, const json& dataset) {
  out << format("`%s`: %zu frames, %.1f s, %d x %d pixels.\n\n", dataset.at("name").get<std::string>().c_str(),
                dataset.at("frames").get<std::size_t>(), dataset.at("duration_s").get<double>(),
                dataset.at("width").get<int>(), dataset.at("height").get<int>());
}

/// Visits configurations without a map and with one, as they are named in tables.
template <class Visit>
void for_each_row(const json& comparison, const json& dataset, const Visit& visit) {
  for (const json& configuration : comparison.at("configurations")) {
    for (const bool with_map : {false, true}) {
      const Summary summary = summary_of(comparison, configuration, dataset, with_map);
      const auto name = configuration.at("name").get<std::string>();
      if (summary.runs > 0) visit(with_map ? name + " --map" : name, summary);
    }
  }
}

/// What a map adds to a row: "3 loops, final 0.0123 m".
std::string text_of_map(const Summary& summary) {
  if (summary.loops.empty()) return {};
  return format("%g loops, ATE of final poses ", median(summary.loops)) + meters(median(summary.final_ate_m));
}

/// A table for each data set whose rows are those of `row_of`, of a summary that has runs.
template <class RowOf>
void print_rows(std::ostream& out, const json& comparison, const char* columns, const RowOf& row_of) {
  for (const json& dataset : comparison.at("datasets")) {
    std::string rows;
    for_each_row(comparison, dataset, [&](const std::string& name, const Summary& summary) {
      rows += "| `" + name + "` | " + row_of(summary) + " |\n";
    });
    if (rows.empty()) continue;
    print_heading(out, dataset);
    out << "| configuration |" << columns << " |\n| --- |";
    for (const char* c = columns; *c != 0; ++c) out << (c == columns || *c == '|' ? " --- |" : "");
    out << '\n' << rows << '\n';
  }
}

}  // namespace

void print_table(std::ostream& out, const json& comparison) {
  for (const json& dataset : comparison.at("datasets")) {
    out << format("%s: %zu frames, %.1f s\n  %-40s %-9s %10s %10s %8s %7s %6s\n",
                  dataset.at("name").get<std::string>().c_str(), dataset.at("frames").get<std::size_t>(),
                  dataset.at("duration_s").get<double>(), "", "alignment", "ATE median", "worst", "coverage", "failed",
                  "ms");
    for_each_row(comparison, dataset, [&](const std::string& name, const Summary& summary) {
      const std::string map = text_of_map(summary);
      out << format("  %-40s %-9s %10s %10s %8s %7s %6s%s\n", name.c_str(), summary.alignment.c_str(),
                    meters(summary.median_ate_m()).c_str(), meters(summary.worst_ate_m()).c_str(),
                    percent(summary.lowest_coverage()).c_str(),
                    format("%zu of %zu", summary.failed, summary.runs).c_str(), milliseconds(summary.ms).c_str(),
                    map.empty() ? "" : ("  " + map).c_str());
    });
    out << '\n';
  }
  out << wrapped(legend_of(comparison));
}

void print_markdown(std::ostream& out, const json& comparison) {
  out << "| configuration | alignment |";
  for (const json& dataset : comparison.at("datasets")) out << " `" << dataset.at("name").get<std::string>() << "` |";
  out << "\n| --- | --- |";
  for (std::size_t i = 0; i < comparison.at("datasets").size(); ++i) out << " --- |";
  out << '\n';
  for (const json& configuration : comparison.at("configurations")) {
    for (const bool with_map : {false, true}) {
      std::string alignment, cells;
      for (const json& dataset : comparison.at("datasets")) {
        const Summary summary = summary_of(comparison, configuration, dataset, with_map);
        if (summary.runs > 0) {
          alignment = summary.alignment;
          cells += " " + meters(summary.median_ate_m()) + ", worst " + meters(summary.worst_ate_m()) + ", " +
                   percent(summary.lowest_coverage()) + ", " + milliseconds(summary.ms) + " ms";
          if (with_map && !summary.loops.empty()) cells += ", " + text_of_map(summary);
          if (summary.failed > 0) cells += format(", %zu of %zu failed", summary.failed, summary.runs);
        }
        cells += " |";
      }
      if (!alignment.empty())
        out << "| `" << configuration.at("name").get<std::string>() << (with_map ? " --map" : "") << "` | " << alignment
            << " |" << cells << '\n';
    }
  }
  out << '\n' << wrapped("Each cell: ATE median and worst, coverage, time of a frame. " + legend_of(comparison));
}

void print_accuracy(std::ostream& out, const json& comparison) {
  print_rows(out, comparison, " alignment | ATE median | ATE worst | RPE 1 s | coverage | failed runs",
             [](const Summary& s) {
               const std::string rpe =
                   s.rpe_m.empty() ? "-" : meters(median(s.rpe_m)) + ", " + format("%.2f deg", median(s.rpe_deg));
               return s.alignment + " | " + meters(s.median_ate_m()) + " | " + meters(s.worst_ate_m()) + " | " + rpe +
                      " | " + percent(s.lowest_coverage()) + " | " + format("%zu of %zu", s.failed, s.runs);
             });
  out << wrapped(std::string("ATE: root mean square of the position error after alignment ") + alignments +
                 ", median and worst of " + text_of_runs(comparison) +
                 ". RPE: root mean square of the error of the motion within one second, translation and rotation, "
                 "median of the runs. Coverage: frames with a pose, of those with truth; the lowest of the runs. A "
                 "failed run counts as an infinite error and as no coverage.");
}

void print_timing(std::ostream& out, const json& comparison) {
  const auto& runs = comparison.at("runs");
  const bool has_map =
      std::any_of(runs.begin(), runs.end(), [](const json& run) { return run.value("with_map", false); });
  const std::string columns =
      std::string(" CPU median | median | 99 % | longest") + (has_map ? " | learn | query | verify | solve" : "");
  print_rows(out, comparison, columns.c_str(), [has_map](const Summary& s) {
    const std::string longest =
        s.wall_max_ms.empty() ? "-" : format("%.1f", *std::max_element(s.wall_max_ms.begin(), s.wall_max_ms.end()));
    std::string row =
        milliseconds(s.ms) + " | " + milliseconds(s.wall_ms) + " | " + milliseconds(s.wall_p99_ms) + " | " + longest;
    for (const char* stage : {"learn", "query", "verify", "solve"}) {
      if (!has_map) break;
      const auto ms = s.map_ms.find(stage);
      row += ms == s.map_ms.end() || ms->second.empty()
                 ? " | -"
                 : format(" | %.3f (%.1f)", median(ms->second), s.longest_map_ms.at(stage));
    }
    return row;
  });
  out << wrapped("Milliseconds of a frame in the estimator, without the decoding of images, medians of " +
                 text_of_runs(comparison) +
                 "; longest: of all runs. CPU: time of the processor; the other columns are elapsed time. " +
                 (has_map ? "Learn, query, verify, solve: stages of the map, which are part of the frame, mean of all "
                            "frames (longest). "
                          : "") +
                 text_of_machines(comparison) + ".");
}
