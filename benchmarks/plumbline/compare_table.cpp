#include "compare_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "format.hpp"
#include "statistics.hpp"

using nlohmann::json;

namespace {

/// Of the runs of one configuration on one data set; no ATE is printed without the rest.
struct Summary {
  std::size_t runs = 0, failed = 0;
  std::string alignment;
  std::vector<double> ate_m;     ///< infinite of a failed run
  std::vector<double> coverage;  ///< zero of a failed run
  std::vector<double> ms;        ///< of the processor, medians of the runs that had frames

  double median_ate_m() const { return median(ate_m); }
  double worst_ate_m() const { return *std::max_element(ate_m.begin(), ate_m.end()); }
  double lowest_coverage() const { return *std::min_element(coverage.begin(), coverage.end()); }
};

Summary summary_of(const json& comparison, const json& configuration, const json& dataset) {
  Summary out;
  for (const json& run : comparison.at("runs")) {
    if (run.at("configuration") != configuration.at("name") || run.at("dataset") != dataset.at("name")) continue;
    const bool is_ok = run.at("status") == "ok";
    ++out.runs;
    out.failed += !is_ok;
    out.alignment = run.at("alignment").get<std::string>();
    out.ate_m.push_back(is_ok ? run.at("ate").at("rmse").get<double>() : std::numeric_limits<double>::infinity());
    out.coverage.push_back(is_ok ? run.at("coverage").get<double>() : 0);
    const json& times = run.at("time_ms");
    if (!times.is_null() && !times.at("cpu_median").is_null()) out.ms.push_back(times.at("cpu_median").get<double>());
  }
  return out;
}

/// Three digits, at most a tenth of a millimetre.
std::string metres(double value) {
  if (std::isinf(value)) return "failed";
  return format("%.*f m", value < 0.1 ? 4 : value < 1 ? 3 : value < 100 ? 2 : 0, value);
}

std::string percent(double share) { return format("%.0f %%", std::floor(100 * share)); }

std::string milliseconds(const std::vector<double>& ms) { return ms.empty() ? "-" : format("%.1f", median(ms)); }

std::string text_of_machine(const json& machine, const json& processes) {
  const auto runs = processes.get<std::size_t>();
  return format("%s, %zu cores, %.1f GiB, %s, %s, %s, plumbline %s; ", machine.at("cpu").get<std::string>().c_str(),
                machine.at("cores").get<std::size_t>(), machine.at("memory_gib").get<double>(),
                machine.at("os").get<std::string>().c_str(), machine.at("compiler").get<std::string>().c_str(),
                machine.at("build").get<std::string>().c_str(), machine.at("plumbline").get<std::string>().c_str()) +
         (runs == 1 ? "one run at a time" : format("up to %zu runs side by side", runs));
}

/// Every machine that took part.
std::string text_of_machines(const json& comparison) {
  std::set<std::string> texts;
  for (const json& run : comparison.at("runs"))
    texts.insert(text_of_machine(run.value("machine", comparison.at("machine")),
                                 run.value("processes", comparison.at("processes"))));
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : "; and ") + text;
  return out;
}

std::string text_of_starts(const json& comparison) {
  std::size_t most = 0;
  for (const json& run : comparison.at("runs")) most = std::max(most, run.at("repeat").get<std::size_t>() + 1);
  return most == 1 ? "one start" : format("%zu starts one frame apart", most);
}

/// Lines of at most 120 columns.
std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string out, word;
  for (std::size_t column = 0; words >> word; column += word.size() + 1) {
    if (column + word.size() > 120) {
      out.back() = '\n';
      column = 0;
    }
    out += word + " ";
  }
  out.back() = '\n';
  return out;
}

std::string legend_of(const json& comparison) {
  return "ATE: root mean square of the position error after alignment (se3: rigid, posyaw: position and heading, sim3: "
         "with scale), median and worst of " +
         text_of_starts(comparison) +
         ", of causal poses: each is the one published with its frame. Coverage: frames with such a pose, of those "
         "with "
         "truth; the lowest of the starts. ms: of the processor, median of the frames. " +
         text_of_machines(comparison) + ".";
}

}  // namespace

void print_table(std::ostream& out, const json& comparison) {
  for (const json& dataset : comparison.at("datasets")) {
    out << format("%s: %zu frames, %.1f s\n  %-40s %-9s %10s %10s %8s %7s %6s\n",
                  dataset.at("name").get<std::string>().c_str(), dataset.at("frames").get<std::size_t>(),
                  dataset.at("duration_s").get<double>(), "", "alignment", "ATE median", "worst", "coverage", "failed",
                  "ms");
    for (const json& configuration : comparison.at("configurations")) {
      const Summary summary = summary_of(comparison, configuration, dataset);
      if (summary.runs == 0) continue;
      out << format("  %-40s %-9s %10s %10s %8s %7s %6s\n", configuration.at("name").get<std::string>().c_str(),
                    summary.alignment.c_str(), metres(summary.median_ate_m()).c_str(),
                    metres(summary.worst_ate_m()).c_str(), percent(summary.lowest_coverage()).c_str(),
                    format("%zu of %zu", summary.failed, summary.runs).c_str(), milliseconds(summary.ms).c_str());
    }
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
    std::string alignment, cells;
    for (const json& dataset : comparison.at("datasets")) {
      const Summary summary = summary_of(comparison, configuration, dataset);
      if (summary.runs > 0) {
        alignment = summary.alignment;
        cells += " " + metres(summary.median_ate_m()) + ", worst " + metres(summary.worst_ate_m()) + ", " +
                 percent(summary.lowest_coverage()) + ", " + milliseconds(summary.ms) + " ms";
        if (summary.failed > 0) cells += format(", %zu of %zu failed", summary.failed, summary.runs);
      }
      cells += " |";
    }
    if (!alignment.empty())
      out << "| `" << configuration.at("name").get<std::string>() << "` | " << alignment << " |" << cells << '\n';
  }
  out << '\n' << wrapped("Each cell: ATE median and worst, coverage, time of a frame. " + legend_of(comparison));
}
