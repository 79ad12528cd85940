#include "relocalizations_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "format.hpp"
#include "statistics.hpp"
#include "table_cells.hpp"

using nlohmann::json;

namespace {

/// Of all runs of a group.
struct RelocalizationSummary {
  std::size_t runs = 0, in_half_a_second = 0, in_a_second = 0, localized = 0, poses = 0, right = 0, queries = 0;
  std::vector<double> after_pose_s;  ///< of the runs that were localized
  double square_m = 0, square_deg = 0, max_m = 0, query_ms = 0;

  explicit RelocalizationSummary(const json& group) {
    for (const json& run : group.at("runs")) {
      ++runs;
      queries += run.at("queries").get<std::size_t>();
      query_ms += run.at("query_ms").get<double>();
      if (run.at("localized_s").is_null()) continue;
      const auto localized_s = run.at("localized_s").get<double>();
      ++localized;
      in_half_a_second += localized_s <= 0.5;
      in_a_second += localized_s <= 1;
      after_pose_s.push_back(localized_s - run.at("pose_s").get<double>());
      const auto n = run.at("poses").get<std::size_t>();
      if (n == 0) continue;
      poses += n;
      right += run.at("right_poses").get<std::size_t>();
      square_m += double(n) * std::pow(run.at("rmse_m").get<double>(), 2);
      square_deg += double(n) * std::pow(run.at("rmse_deg").get<double>(), 2);
      max_m = std::max(max_m, run.at("max_m").get<double>());
    }
  }

  std::string share(std::size_t count) const {
    return runs == 0 ? "-" : percent(double(count) / double(runs)) + format(" (%zu)", count);
  }
  std::string rmse() const {
    return poses == 0 ? "-"
                      : meters(std::sqrt(square_m / double(poses))) +
                            format(", %.2f deg", std::sqrt(square_deg / double(poses)));
  }
  std::string max() const { return poses == 0 ? "-" : meters(max_m); }
  std::string precision() const { return poses == 0 ? "-" : percent(double(right) / double(poses)); }
  std::string after_pose() const { return after_pose_s.empty() ? "-" : format("%.2f s", median(after_pose_s)); }
  std::string query() const { return queries == 0 ? "-" : format("%.2f", query_ms / double(queries)); }
};

void print_relocalization_row(std::ostream& out, const json& group) {
  const RelocalizationSummary s(group);
  out << "| `" << group.at("configuration").get<std::string>() << "` | "
      << format("%zu | %zu of %zu | ", group.at("keyframes").get<std::size_t>(), s.runs,
                s.runs + group.at("out_of_reach").get<std::size_t>())
      << s.share(s.in_half_a_second) << " | " << s.share(s.in_a_second) << " | " << s.share(s.localized) << " | "
      << s.after_pose() << " | " << s.rmse() << " | " << s.max() << " | " << s.precision() << " | " << s.query()
      << " |\n";
}

}  // namespace

void print_relocalization_summary(std::ostream& out, const json& group) {
  const RelocalizationSummary s(group);
  out << format(
      "%zu runs near the map: localized within 0.5 s %s, within 1 s %s, ever %s; error %s, at most %s; %s right; "
      "%s ms a query\n",
      s.runs, s.share(s.in_half_a_second).c_str(), s.share(s.in_a_second).c_str(), s.share(s.localized).c_str(),
      s.rmse().c_str(), s.max().c_str(), s.precision().c_str(), s.query().c_str());
}

void print_relocalizations(std::ostream& out, const json& groups) {
  std::vector<std::string> datasets;
  for (const json& group : groups) {
    const auto name = group.at("dataset").get<std::string>();
    if (std::find(datasets.begin(), datasets.end(), name) == datasets.end()) datasets.push_back(name);
  }
  for (const std::string& dataset : datasets) {
    const auto first =
        std::find_if(groups.begin(), groups.end(), [&](const json& g) { return g.at("dataset") == dataset; });
    const auto every_s = first->at("every_s").get<double>();
    const std::string every = every_s > 0 ? format("every %g s", every_s) : "at every frame";
    out << format("`%s`: a run of %g s %s of the second half.\n\n", dataset.c_str(),
                  first->at("duration_s").get<double>(), every.c_str())
        << "| configuration | keyframes | runs | within 0.5 s | within 1 s | in the run | after the first pose | "
           "RMSE | max | right | ms a query |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    for (const json& group : groups)
      if (group.at("dataset") == dataset) print_relocalization_row(out, group);
    out << '\n';
  }
  const std::string reach = format("%g m and %g degrees", reach_m, reach_deg),
                    bound = format("%g m and %g degrees", right_position_m, right_rotation_deg);
  out << wrapped(
      "Keyframes: of the map of the first half, which the runs do not change. Runs: those that begin within " + reach +
      " of a keyframe, by the truth, of all; only these count. Within 0.5 s, within 1 s, in the run: share (number) of "
      "the runs that are localized so long after their first image. After the first pose: median time from the first "
      "sound pose of a run to the first localized one. RMSE and max: errors of all localized poses in the map, which "
      "is aligned with the truth by the poses of the first half (attitudes and positions; with an IMU heading and "
      "positions); the errors of the map are among them. Right: localized poses within " +
      bound + " of the truth. A query: the search for similar keyframes with the verification of what it finds.");
}
