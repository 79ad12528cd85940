#include "compare_merge.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <tuple>

#include "compare_json.hpp"
#include "plumbline/io/text.hpp"
#include "statistics.hpp"

using nlohmann::json;

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

std::map<std::string, std::size_t> places_of(const json& named) {
  std::map<std::string, std::size_t> out;
  for (const json& each : named) out.emplace(each.at("name").get<std::string>(), out.size());
  return out;
}

json* find_named(json& list, const json& name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const json& each) { return each.at("name") == name; });
  return found == list.end() ? nullptr : &*found;
}

void add_configurations(json& all, const json& others, const std::filesystem::path& file) {
  for (const json& other : others) {
    json* known = find_named(all, other.at("name"));
    if (known == nullptr) {
      all.push_back(other);
      continue;
    }
    json& bytes = known->at("bytes");  // null where this file has no run of it
    if (bytes.is_null()) bytes = other.at("bytes");
    if (!other.at("bytes").is_null() && other.at("bytes") != bytes)
      refuse(file, other.at("name").get<std::string>() + " is another estimator there");
  }
}

void add_datasets(json& all, const json& others, const std::filesystem::path& file) {
  for (const json& other : others) {
    const json* known = find_named(all, other.at("name"));
    if (known == nullptr)
      all.push_back(other);
    else if (*known != other)
      refuse(file, other.at("name").get<std::string>() + " is another recording there");
  }
}

void add_runs(json& all, const json& other) {
  const bool same_machine = other.at("machine") == all.at("machine");
  const bool same_processes = other.at("processes") == all.at("processes");
  for (json run : other.at("runs")) {
    if (!same_machine && !run.contains("machine")) run["machine"] = other.at("machine");
    if (!same_processes && !run.contains("processes")) run["processes"] = other.at("processes");
    all.at("runs").push_back(std::move(run));
  }
}

/// The plans are those of shards (the same), or of comparisons to be put side by side.
void add_plans(json& all, const json& others) {
  for (const json& plan : others)
    if (std::find(all.begin(), all.end(), plan) == all.end()) all.push_back(plan);
}

bool has_map(const json& run) { return run.value("with_map", false); }

using Place = std::tuple<std::size_t, std::size_t, bool, std::size_t>;

Place place_of(const json& run, const std::map<std::string, std::size_t>& configurations,
               const std::map<std::string, std::size_t>& datasets) {
  return {configurations.at(run.at("configuration").get<std::string>()),
          datasets.at(run.at("dataset").get<std::string>()), has_map(run), run.at("repeat").get<std::size_t>()};
}

void require_each_once(const json& comparison, const std::filesystem::path& file) {
  const auto configurations = places_of(comparison.at("configurations")),
             datasets = places_of(comparison.at("datasets"));
  std::set<Place> places;
  for (const json& run : comparison.at("runs"))
    if (!places.insert(place_of(run, configurations, datasets)).second)
      refuse(file, "has again the run of " + run.at("configuration").get<std::string>() + " on " +
                       run.at("dataset").get<std::string>() + ", repeat " + run.at("repeat").dump());
}

void merge_into(json& all, const json& other, const std::filesystem::path& file) {
  if (other.at("machine").at("program") != all.at("machine").at("program"))
    refuse(file, "made by another build of plumbline than the first file");
  if (other.at("part") != all.at("part"))
    refuse(file, "of another part of the recordings (--start, --duration) than the first file");
  add_configurations(all.at("configurations"), other.at("configurations"), file);
  add_datasets(all.at("datasets"), other.at("datasets"), file);
  add_plans(all.at("plans"), other.at("plans"));
  add_runs(all, other);
  require_each_once(all, file);
}

bool same_group(const json& a, const json& b) {
  return a.at("configuration") == b.at("configuration") && a.at("dataset") == b.at("dataset") &&
         has_map(a) == has_map(b);
}

/// Of repeats.
void keep_series_of_typical(std::span<json> runs) {
  const auto ate_m = [](const json& run) { return run.at("ate").at("rmse").get<double>(); };
  std::vector<double> all_m;
  for (const json& run : runs)
    if (run.at("status") == "ok") all_m.push_back(ate_m(run));
  const double median_m = median(all_m);
  const auto distance_m = [&](const json& run) {
    return run.at("status") == "ok" ? std::abs(ate_m(run) - median_m) : std::numeric_limits<double>::infinity();
  };
  const auto typical = std::min_element(runs.begin(), runs.end(),
                                        [&](const json& a, const json& b) { return distance_m(a) < distance_m(b); });
  for (json& run : runs) {
    if (&run == &*typical) continue;
    run.erase("frame_series");
    run.erase("map");
  }
}

}  // namespace

json read_comparison(const std::filesystem::path& file) {
  json out = json::parse(plumbline::io::read_text(file), nullptr, false);
  if (out.is_discarded()) refuse(file, "is not JSON");
  if (!out.is_object() || out.value("format", json()) != "plumbline-compare")
    refuse(file, "is not a comparison that plumbline compare wrote");
  if (out.value("version", json()) != 1) refuse(file, "is a comparison of another version than 1");
  return out;
}

json merge_comparisons(const std::vector<std::filesystem::path>& files) {
  json out;
  for (const std::filesystem::path& file : files) {
    try {
      json each = read_comparison(file);
      if (out.is_null()) {
        out = std::move(each);
        require_each_once(out, file);
      } else {
        merge_into(out, each, file);
      }
    } catch (const json::exception&) {
      refuse(file, "is not a whole comparison");
    } catch (const std::out_of_range&) {
      refuse(file, "has a run of a configuration or a data set that it does not list");
    }
  }
  finish(out);
  return out;
}

std::size_t planned_runs(const json& comparison) {
  std::size_t runs = 0;
  for (const json& plan : comparison.at("plans")) runs += plan.at("runs").get<std::size_t>();
  return runs;
}

void finish(json& comparison) {
  const auto configurations = places_of(comparison.at("configurations")),
             datasets = places_of(comparison.at("datasets"));
  auto& runs = comparison.at("runs").get_ref<json::array_t&>();
  std::sort(runs.begin(), runs.end(), [&](const json& a, const json& b) {
    return place_of(a, configurations, datasets) < place_of(b, configurations, datasets);
  });
  if (runs.size() < planned_runs(comparison)) return;
  for (auto begin = runs.begin(); begin != runs.end();) {
    const auto end = std::find_if(begin, runs.end(), [&](const json& run) { return !same_group(*begin, run); });
    keep_series_of_typical({begin, end});
    begin = end;
  }
}
