#include "starts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>

#include "compare_json.hpp"
#include "format.hpp"
#include "plumbline/io/trajectory_alignment.hpp"
#include "starts_table.hpp"
#include "table_cells.hpp"
#include "trial.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;
using nlohmann::json;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

struct StartOutcome {
  double pose_s = never, tracking_s = never;  ///< after the first frame
  /// Over two seconds from `tracking` on, and over the last two; NaN where next to nothing moves.
  double scale_error = NAN, last_scale_error = NAN;
  int false_frames = 0;
};

/// |1 - scale| of the estimate over an interval; NaN where next to nothing moves.
double scale_error(const LoadedRecording& recording, const std::vector<JudgedFrame>& frames, pl::TimeNs begin_ns,
                   pl::TimeNs end_ns) {
  io::Trajectory estimate;
  for (const JudgedFrame& frame : frames) {
    if (frame.t_ns >= begin_ns && frame.t_ns <= end_ns && std::isfinite(frame.error_m))
      estimate.push_back({frame.t_ns, frame.estimate.T_world_body});
  }
  const std::vector<io::PosePair> pairs = io::associate(recording.truth, estimate, 0.02);
  double path_m = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) path_m += (pairs[i].reference.p() - pairs[i - 1].reference.p()).norm();
  const auto S = io::align(pairs, io::Alignment::sim3);
  return S && path_m > 0.2 ? std::abs(1 - S->scale()) : std::nan("");
}

StartOutcome outcome_of(const LoadedRecording& recording, const std::vector<JudgedFrame>& frames) {
  StartOutcome out;
  const pl::TimeNs begin_ns = frames.front().t_ns, two_s = 2'000'000'000;
  pl::TimeNs tracking_ns = 0;
  for (const JudgedFrame& frame : frames) {
    const pl::HealthState state = frame.estimate.health.state;
    const double t_s = pl::seconds_between(begin_ns, frame.t_ns);
    if (state == pl::HealthState::tracking || state == pl::HealthState::degraded)
      out.pose_s = std::min(out.pose_s, t_s);
    if (state == pl::HealthState::tracking && tracking_ns == 0) {
      out.tracking_s = t_s;
      tracking_ns = frame.t_ns;
    }
    out.false_frames += frame.is_false();
  }
  if (tracking_ns == 0) return out;
  out.scale_error = scale_error(recording, frames, tracking_ns, tracking_ns + two_s);
  out.last_scale_error = scale_error(recording, frames, frames.back().t_ns - two_s, frames.back().t_ns);
  return out;
}

json json_of(const StartOutcome& outcome, double begin_s, const std::vector<JudgedFrame>& frames) {
  const pl::Health& health = frames.back().estimate.health;
  return {{"begin_s", rounded(begin_s, 6)},
          {"frames", frames.size()},
          {"pose_s", rounded(outcome.pose_s, 3)},
          {"tracking_s", rounded(outcome.tracking_s, 3)},
          {"scale_error", rounded(outcome.scale_error, 5)},
          {"last_scale_error", rounded(outcome.last_scale_error, 5)},
          {"false_frames", outcome.false_frames},
          {"last_state", name_of(health.state)},
          {"last_reason", name_of(health.reason)}};
}

/// For the terminal, when a run has ended.
void print_start(const json& run) {
  std::printf("%8.1f %8s %8s %8s %8s %8d  %s, %s\n", run.at("begin_s").get<double>(),
              number(run.at("pose_s"), 2).c_str(), number(run.at("tracking_s"), 2).c_str(),
              number(run.at("scale_error"), 1, 100).c_str(), number(run.at("last_scale_error"), 1, 100).c_str(),
              run.at("false_frames").get<int>(), run.at("last_state").get<std::string>().c_str(),
              run.at("last_reason").get<std::string>().c_str());
  std::fflush(stdout);
}

/// All runs of one configuration on one recording.
json run_starts(const Configuration& configuration, const LoadedRecording& recording, const StartOptions& options) {
  std::printf("%s on %s\n%8s %8s %8s %8s %8s %8s  %s\n", configuration.name, recording.name.c_str(), "begin s",
              "pose s", "track s", "scale %", "later %", "false", "last health");
  json group = {{"configuration", configuration.name},
                {"dataset", recording.name},
                {"every_s", options.every_s},
                {"duration_s", options.duration_s},
                {"runs", json::array()}};
  const double length_s = pl::seconds_between(recording.begin_ns, recording.end_ns);
  for (double begin_s = 0; begin_s + options.duration_s <= length_s; begin_s += options.every_s) {
    const pl::TimeNs begin_ns = recording.begin_ns + std::llround(1e9 * begin_s);
    const pl::TimeNs end_ns = begin_ns + std::llround(1e9 * options.duration_s);
    const auto frames = run_trial(configuration, recording, begin_ns, end_ns, [](Event&) { return true; }).frames;
    if (frames.empty()) continue;
    group["runs"].push_back(json_of(outcome_of(recording, frames), begin_s, frames));
    print_start(group["runs"].back());
  }
  print_summary(std::cout, group);
  std::cout.flush();
  return group;
}

std::string command_of(const StartOptions& options) {
  std::vector<std::string> words{"plumbline", "starts", "--config"};
  words.insert(words.end(), options.configs.begin(), options.configs.end());
  words.emplace_back("--dataset");
  for (const auto& dataset : options.datasets) words.push_back(name_of_recording(dataset));
  for (const std::string& word : options.inputs.words()) words.push_back(word);
  words.insert(words.end(), {"--every", format("%g", options.every_s), "--duration", format("%g", options.duration_s)});
  if (options.with_map) words.emplace_back("--map");
  return command_line(words);
}

}  // namespace

int run_starts(const StartOptions& options) {
  check_results(options.results);
  json result = result_of("initialization", command_of(options), options.results);
  result["groups"] = json::array();
  for (const std::string& name : options.configs) {
    const Configuration& configuration = configuration_named(name);
    for (const auto& dataset : options.datasets) {
      LoadedRecording recording = load_recording(dataset, configuration, options.inputs);
      print_notes(recording.notes);
      recording.with_map = options.with_map;
      recording.name = name_of_recording(dataset);
      result["groups"].push_back(run_starts(configuration, recording, options));
    }
  }
  write_results(options.results, result);
  return 0;
}
