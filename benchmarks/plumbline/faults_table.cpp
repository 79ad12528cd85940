#include "faults_table.hpp"

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

double or_infinite(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

/// One fault at all its times.
struct FaultSummary {
  std::vector<double> ate_m;  ///< infinite of a run without a pose
  double worst_m = 0, recovered_s = 0;
  std::size_t false_frames = 0, lost_frames = 0, resets = 0;

  explicit FaultSummary(const json& fault) {
    for (const json& run : fault.at("runs")) {
      ate_m.push_back(or_infinite(run.at("ate_m")));
      worst_m = std::max(worst_m, ate_m.back());
      recovered_s = std::max(recovered_s, or_infinite(run.at("recovered_s")));
      false_frames += run.at("false_frames").get<std::size_t>();
      lost_frames += run.at("lost_frames").get<std::size_t>();
      resets += run.at("resets").get<std::size_t>();
    }
  }
  /// Of the worst error to that of the run without a fault.
  double ratio(const json& clean) const { return worst_m / or_infinite(clean.at("ate_m")); }
};

std::string text_of_length(const json& fault) {
  return fault.at("duration_s").is_null() ? "" : format("%g s", fault.at("duration_s").get<double>());
}

/// Three digits.
std::string factor(double value) {
  if (!std::isfinite(value)) return "-";
  return format("%.*f", value < 10 ? 2 : value < 100 ? 1 : 0, value);
}

/// "1.19; 0.4 s; 42".
std::string fault_cell(const json& clean, const json& fault) {
  const FaultSummary summary(fault);
  return factor(summary.ratio(clean)) +
         (std::isinf(summary.recovered_s) ? "; never" : format("; %.1f s", summary.recovered_s)) +
         format("; %zu", summary.false_frames);
}

const json* find_fault(const json& group, const json& name, const json& duration_s) {
  for (const json& fault : group.at("faults"))
    if (fault.at("name") == name && fault.at("duration_s") == duration_s) return &fault;
  return nullptr;
}

/// Of the groups of one recording.
void print_fault_table(std::ostream& out, const std::vector<const json*>& groups) {
  out << "| fault |";
  for (const json* group : groups) out << " `" << group->at("configuration").get<std::string>() << "` |";
  out << "\n| --- |";
  for (std::size_t i = 0; i < groups.size(); ++i) out << " --- |";
  out << "\n| none |";
  for (const json* group : groups) {
    const json& clean = group->at("clean");
    out << ' ' << (clean.at("ate_m").is_null() ? "no pose" : meters(clean.at("ate_m").get<double>())) << "; "
        << clean.at("false_frames") << " |";
  }
  out << '\n';
  std::vector<const json*> rows;
  for (const json* group : groups) {
    for (const json& fault : group->at("faults")) {
      const auto is_same = [&](const json* row) {
        return row->at("name") == fault.at("name") && row->at("duration_s") == fault.at("duration_s");
      };
      if (std::none_of(rows.begin(), rows.end(), is_same)) rows.push_back(&fault);
    }
  }
  for (const json* row : rows) {
    const std::string length = text_of_length(*row);
    out << "| " << row->at("name").get<std::string>() << (length.empty() ? "" : ", ") << length << " |";
    for (const json* group : groups) {
      const json* fault = find_fault(*group, row->at("name"), row->at("duration_s"));
      out << (fault == nullptr ? "" : " " + fault_cell(group->at("clean"), *fault)) << " |";
    }
    out << '\n';
  }
}

}  // namespace

void print_clean_run(std::ostream& out, const json& group) {
  const json& clean = group.at("clean");
  out << format("%s on %s: %s m, %zu frames, %zu falsely tracking\n",
                group.at("configuration").get<std::string>().c_str(), group.at("dataset").get<std::string>().c_str(),
                number(clean.at("ate_m"), 4).c_str(), clean.at("frames").get<std::size_t>(),
                clean.at("false_frames").get<std::size_t>())
      << format("%-17s %6s %9s %9s %6s %7s %6s %6s %7s\n", "fault", "", "median m", "worst m", "ratio", "again s",
                "false", "lost", "resets");
}

void print_fault(std::ostream& out, const json& clean, const json& fault) {
  const FaultSummary summary(fault);
  out << format("%-17s %6s %9.4f %9.4f %6.2f %7.2f %6zu %6zu %7zu\n", fault.at("name").get<std::string>().c_str(),
                text_of_length(fault).c_str(), median(summary.ate_m), summary.worst_m, summary.ratio(clean),
                summary.recovered_s, summary.false_frames, summary.lost_frames, summary.resets);
}

void print_faults(std::ostream& out, const json& groups) {
  std::vector<std::string> datasets;
  std::size_t times = 1;
  for (const json& group : groups) {
    const auto name = group.at("dataset").get<std::string>();
    if (std::find(datasets.begin(), datasets.end(), name) == datasets.end()) datasets.push_back(name);
    for (const json& fault : group.at("faults")) times = std::max(times, fault.at("runs").size());
  }
  for (const std::string& dataset : datasets) {
    // configurations with different sensors have different faults: tables of their own
    std::vector<std::string> sensors;
    const auto sensors_of = [](const json& group) {
      const auto name = group.at("configuration").get<std::string>();
      return name.substr(0, name.find('/'));
    };
    for (const json& group : groups)
      if (group.at("dataset") == dataset &&
          std::find(sensors.begin(), sensors.end(), sensors_of(group)) == sensors.end())
        sensors.push_back(sensors_of(group));
    for (const std::string& each : sensors) {
      std::vector<const json*> columns;
      for (const json& group : groups)
        if (group.at("dataset") == dataset && sensors_of(group) == each) columns.push_back(&group);
      out << '`' << dataset << "`:\n\n";
      print_fault_table(out, columns);
      out << '\n';
    }
  }
  out << wrapped(
      "Row `none`: ATE, and false frames. Other rows, over " + counted(times, "run") +
      " with the fault at different times: the largest ATE as a multiple of that without a fault; the longest time "
      "from the end of the fault (its begin where it has no end) to the next `tracking` frame; false frames "
      "in the sum of the runs, each of which has those without a fault, too. False frames: `tracking` frames whose "
      "error since the first pose exceeds 3 "
      "sigma of the published covariance, in position or rotation.");
}
