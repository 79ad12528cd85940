#include "relocalizations.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include "compare_json.hpp"
#include "final_trajectory.hpp"
#include "format.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/io/trajectory_alignment.hpp"
#include "relocalizations_table.hpp"
#include "table_cells.hpp"
#include "trial.hpp"
#include "truth_comparison.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;
using nlohmann::json;

namespace {

double angle_deg_between(const pl::SE3<double>& a, const pl::SE3<double>& b) {
  return degrees * (a.rotation().inverse() * b.rotation()).log().norm();
}

/// S_truth_map from attitudes, with scale and position from positions: a path may be too short for its positions to
/// determine the attitude of the map. With an IMU, position and heading from positions. Nothing without three pairs.
std::optional<pl::Sim3<double>> alignment_of_map(const std::vector<io::PosePair>& pairs, const Needs& needs) {
  if (pairs.size() < 3) return std::nullopt;
  if (needs.imu) return io::align(pairs, io::Alignment::posyaw);
  const auto n = static_cast<double>(pairs.size());
  pl::SO3<double> R;
  pl::Vec<double, 3> mean_truth = pl::Vec<double, 3>::Zero(), mean = mean_truth;
  for (int iteration = 0; iteration < 10; ++iteration) {
    pl::Vec<double, 3> rest = pl::Vec<double, 3>::Zero();
    for (const io::PosePair& pair : pairs)
      rest += (R.inverse() * pair.reference.rotation() * pair.estimate.rotation().inverse()).log() / n;
    R = R * pl::SO3<double>::exp(rest);
  }
  for (const io::PosePair& pair : pairs) {
    mean_truth += pair.reference.p() / n;
    mean += pair.estimate.p() / n;
  }
  double scale = 1, products = 0, squares = 0;
  for (const io::PosePair& pair : pairs) {
    const pl::Vec<double, 3> p = R * pl::Vec<double, 3>(pair.estimate.p() - mean);
    products += p.dot(pair.reference.p() - mean_truth);
    squares += p.squaredNorm();
  }
  if (!needs.depth) scale = products / squares;
  if (!(scale > 0) || !std::isfinite(scale)) return std::nullopt;
  return pl::Sim3<double>(scale, R, mean_truth - scale * (R * mean));
}

/// The map of a part of a recording, beside the truth.
struct LearnedMap {
  std::vector<std::byte> bytes;
  std::vector<pl::SE3<double>> keyframes;  ///< true poses of the body
  pl::Sim3<double> S_truth_map;
};

LearnedMap learn_map(const Configuration& configuration, const LoadedRecording& recording, pl::TimeNs end_ns) {
  const auto runner = configuration.make(recording.calibration, true);
  io::Trajectory poses;
  run_events(
      *runner, recording, recording.begin_ns, end_ns, [](Event&) { return true; },
      [&](const FrameOutput& output) {
        if (output.has_sound_pose()) poses.push_back({output.pose_ns(), output.estimate.T_world_body});
      });
  const std::optional<MapSummary> summary = runner->map_summary();
  LearnedMap out{runner->saved_map(), {}, {}};
  const io::MapContents contents = io::map_of_bytes(out.bytes, recording.name);
  for (const auto& entry : contents.keyframes)
    if (const auto truth = truth_at(recording.truth, entry.keyframe.t_ns)) out.keyframes.push_back(*truth);
  const io::Trajectory final_poses = final_trajectory(poses, summary.value().corrections);
  const auto S = alignment_of_map(io::associate(recording.truth, final_poses, 0.02), configuration.needs);
  if (out.keyframes.empty() || !S)
    throw std::runtime_error(recording.name + ": no map of the first half with " + configuration.name);
  out.S_truth_map = *S;
  return out;
}

/// Whether a keyframe of the map sees about the same.
bool is_in_reach(const LearnedMap& map, const pl::SE3<double>& pose) {
  return std::any_of(map.keyframes.begin(), map.keyframes.end(), [&](const pl::SE3<double>& keyframe) {
    return (keyframe.p() - pose.p()).norm() <= reach_m && angle_deg_between(keyframe, pose) <= reach_deg;
  });
}

/// A run that looks for its place.
json localize(const Configuration& configuration, const LoadedRecording& recording, const LearnedMap& map,
              pl::TimeNs begin_ns, pl::TimeNs end_ns) {
  const auto runner = configuration.make(recording.calibration, {true, true});
  if (const pl::MapArchiveError error = runner->load_map(map.bytes); error != pl::MapArchiveError::none)
    throw std::runtime_error(recording.name + ": " + pl::name_of(error));
  constexpr double not_yet = std::numeric_limits<double>::infinity();
  double pose_s = not_yet, localized_s = not_yet, square_m = 0, square_deg = 0, max_m = 0, query_ms = 0;
  std::size_t poses = 0, right_poses = 0;
  run_events(
      *runner, recording, begin_ns, end_ns, [](Event&) { return true; },
      [&](const FrameOutput& output) {
        query_ms += 1e3 * (output.map_timing.query + output.map_timing.verify);
        if (!output.has_sound_pose()) return;
        const double t_s = pl::seconds_between(begin_ns, output.estimate.t_ns);
        pose_s = std::min(pose_s, t_s);
        if (!output.is_in_map) return;
        localized_s = std::min(localized_s, t_s);
        const auto truth = truth_at(recording.truth, output.pose_ns());
        if (!truth) return;
        const pl::SE3<double> pose = io::aligned(map.S_truth_map, output.T_map_body());
        const double error_m = (pose.p() - truth->p()).norm(), error_deg = angle_deg_between(pose, *truth);
        ++poses;
        square_m += error_m * error_m;
        square_deg += error_deg * error_deg;
        max_m = std::max(max_m, error_m);
        right_poses += error_m <= right_position_m && error_deg <= right_rotation_deg;
      });
  return {{"begin_s", rounded(pl::seconds_between(recording.begin_ns, begin_ns), 6)},
          {"pose_s", rounded(pose_s, 3)},
          {"localized_s", rounded(localized_s, 3)},
          {"poses", poses},
          {"right_poses", right_poses},
          {"rmse_m", rounded(std::sqrt(square_m / double(poses)), 5)},
          {"rmse_deg", rounded(std::sqrt(square_deg / double(poses)), 4)},
          {"max_m", poses > 0 ? rounded(max_m, 5) : json()},
          {"queries", runner->map_summary().value().counts.queries},
          {"query_ms", rounded(query_ms, 3)}};
}

/// For the terminal, when a run has ended.
void print_relocalization(const json& run) {
  std::printf("%8.2f %8s %8s %8zu %8zu %8s %8s %8s\n", run.at("begin_s").get<double>(),
              number(run.at("pose_s"), 2).c_str(), number(run.at("localized_s"), 2).c_str(),
              run.at("poses").get<std::size_t>(), run.at("right_poses").get<std::size_t>(),
              number(run.at("rmse_m"), 3).c_str(), number(run.at("max_m"), 3).c_str(),
              number(run.at("rmse_deg"), 2).c_str());
  std::fflush(stdout);
}

/// All runs of one configuration on one recording.
json run_relocalizations(const Configuration& configuration, const LoadedRecording& recording,
                         const RelocalizationOptions& options) {
  const pl::TimeNs middle_ns = recording.begin_ns + (recording.end_ns - recording.begin_ns) / 2;
  const LearnedMap map = learn_map(configuration, recording, middle_ns);
  std::printf("%s on %s, a map of %zu keyframes\n%8s %8s %8s %8s %8s %8s %8s %8s\n", configuration.name,
              recording.name.c_str(), map.keyframes.size(), "begin s", "pose s", "in map s", "poses", "right", "RMSE m",
              "max m", "RMSE deg");
  json group = {{"configuration", configuration.name},
                {"dataset", recording.name},
                {"every_s", options.every_s},
                {"duration_s", options.duration_s},
                {"keyframes", map.keyframes.size()},
                {"map_bytes", map.bytes.size()},
                {"out_of_reach", 0},
                {"runs", json::array()}};
  const pl::TimeNs duration_ns = std::llround(1e9 * options.duration_s), every_ns = std::llround(1e9 * options.every_s);
  std::size_t out_of_reach = 0;
  pl::TimeNs next_ns = middle_ns + 1;
  for (const Event& event : recording.events) {
    const auto* picture = std::get_if<Picture>(&event);
    if (!picture || picture->t_ns < next_ns || picture->t_ns + duration_ns > recording.end_ns) continue;
    const auto truth = truth_at(recording.truth, picture->t_ns);
    if (!truth) continue;
    next_ns = std::max(next_ns + every_ns, picture->t_ns + 1);
    if (!is_in_reach(map, *truth)) {
      ++out_of_reach;
      continue;
    }
    group["runs"].push_back(localize(configuration, recording, map, picture->t_ns, picture->t_ns + duration_ns));
    print_relocalization(group["runs"].back());
  }
  group["out_of_reach"] = out_of_reach;
  print_relocalization_summary(std::cout, group);
  std::cout.flush();
  return group;
}

std::string command_of(const RelocalizationOptions& options) {
  std::vector<std::string> words{"plumbline", "relocalizations", "--config"};
  words.insert(words.end(), options.configs.begin(), options.configs.end());
  words.emplace_back("--dataset");
  for (const auto& dataset : options.datasets) words.push_back(name_of_recording(dataset));
  for (const std::string& word : options.inputs.words()) words.push_back(word);
  words.insert(words.end(), {"--every", format("%g", options.every_s), "--duration", format("%g", options.duration_s)});
  return command_line(words);
}

}  // namespace

int run_relocalizations(const RelocalizationOptions& options) {
  check_results(options.results);
  json result = result_of("relocalizations", command_of(options), options.results);
  result["groups"] = json::array();
  for (const std::string& name : options.configs) {
    const Configuration& configuration = configuration_named(name);
    for (const auto& dataset : options.datasets) {
      LoadedRecording recording = load_recording(dataset, configuration, options.inputs);
      print_notes(recording.notes);
      recording.name = name_of_recording(dataset);
      result["groups"].push_back(run_relocalizations(configuration, recording, options));
    }
  }
  write_results(options.results, result);
  return 0;
}
