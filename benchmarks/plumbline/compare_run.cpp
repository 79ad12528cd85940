#include "compare_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "compare_json.hpp"
#include "final_trajectory.hpp"
#include "images.hpp"
#include "map_json.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "statistics.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

constexpr double max_difference_s = 0.02;  // between a pose and its truth

/// What is kept of the frames, one number of each.
struct FrameSeries {
  std::vector<double> t, track_ms, estimate_ms, map_ms, total_ms, health, points, lines;
  std::vector<double> learn_ms, query_ms, verify_ms, solve_ms;  ///< of the map

  nlohmann::json json(bool with_map) const {
    nlohmann::json out = {
        {"t", rounded(t, 4)},           {"track_ms", rounded(track_ms, 3)}, {"estimate_ms", rounded(estimate_ms, 3)},
        {"map_ms", rounded(map_ms, 3)}, {"total_ms", rounded(total_ms, 3)}, {"health", rounded(health, 0)},
        {"points", rounded(points, 0)}, {"lines", rounded(lines, 0)}};
    if (!with_map) return out;
    for (const auto& [name, ms] : map_stages()) out["map_" + name + "_ms"] = rounded(*ms, 3);
    return out;
  }
  /// Of the map, with their names.
  std::array<std::pair<std::string, const std::vector<double>*>, 4> map_stages() const {
    return {{{"learn", &learn_ms}, {"query", &query_ms}, {"verify", &verify_ms}, {"solve", &solve_ms}}};
  }
};

/// The output of a run, before it is evaluated.
struct Observed {
  FrameSeries frames;
  io::Trajectory poses, world_poses;     ///< the same in the map, and in the world
  std::vector<double> times_ms, cpu_ms;  ///< of the frames with an estimate
  std::array<std::size_t, 4> health{};   ///< frames in each state
  std::uint32_t resets = 0;
  /// As each feature was last known, in the map.
  std::map<std::pair<int, std::uint32_t>, MapFeature> map;
  std::optional<MapSummary> summary;  ///< nothing without a map
  io::MapContents contents;           ///< the same
};

/// Nothing where a file is damaged: the run continues with the next frame.
std::optional<Images> read_if_whole(const io::FrameSample& frame, bool with_depth) {
  try {
    return read_images(frame, with_depth);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// Of this thread: what runs beside it on the same core does not count.
double cpu_time_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Adds a frame; without output it was not one that the estimator could be given.
void add(Observed& observed, double t_s, const std::optional<FrameOutput>& output, const Runner& runner) {
  const bool is_used = output && !output->refused;
  if (output) observed.resets = output->estimate.resets;
  const auto state = output                           ? static_cast<std::size_t>(output->health())
                     : observed.frames.health.empty() ? 0
                                                      : static_cast<std::size_t>(observed.frames.health.back());
  ++observed.health.at(state);
  const auto ms = [&](auto stage) { return is_used ? 1e3 * std::invoke(stage, output->timing) : std::nan(""); };
  if (is_used) observed.times_ms.push_back(ms(&pl::FrameTiming::total));
  const FeatureCounts seen = runner.seen();
  FrameSeries& frames = observed.frames;
  const auto map_ms = [&](auto stage) { return is_used ? 1e3 * std::invoke(stage, output->map_timing) : std::nan(""); };
  frames.learn_ms.push_back(map_ms(&MapTiming::learn));
  frames.query_ms.push_back(map_ms(&MapTiming::query));
  frames.verify_ms.push_back(map_ms(&MapTiming::verify));
  frames.solve_ms.push_back(map_ms(&MapTiming::solve));
  frames.t.push_back(t_s);
  frames.track_ms.push_back(ms(&pl::FrameTiming::track));
  frames.estimate_ms.push_back(ms(&pl::FrameTiming::estimate));
  frames.map_ms.push_back(ms(&pl::FrameTiming::map));
  frames.total_ms.push_back(ms(&pl::FrameTiming::total));
  frames.health.push_back(static_cast<double>(state));
  frames.points.push_back(seen.points);
  frames.lines.push_back(seen.lines);
}

Observed observe(const CompareJob& job, io::Recording& recording, Runner& runner) {
  const Needs& needs = job.configuration->needs;
  const io::CameraCalibration& camera = recording.calibration().camera;
  Observed out;
  io::Recording::Sample sample;
  while (recording.next(sample, runner.time_offset_s())) {
    if (const auto* imu = std::get_if<pl::ImuSample>(&sample)) {
      if (needs.imu) runner.add_imu(*imu);
      continue;
    }
    const auto& frame = std::get<io::FrameSample>(sample);
    const double t_s = pl::seconds_between(job.dataset->frames.front(), frame.t_ns);
    const std::optional<Images> images = read_if_whole(frame, needs.depth);
    if (!images) {
      add(out, t_s, std::nullopt, runner);
      continue;
    }
    if (out.times_ms.empty()) require_calibrated_size(frame, *images, camera);
    const double begin_ms = cpu_time_ms();
    const FrameOutput output = runner.add_frame(frame.t_ns, images->gray, images->depth);
    if (!output.refused) out.cpu_ms.push_back(cpu_time_ms() - begin_ms);
    add(out, t_s, output, runner);
    if (!output.has_sound_pose()) continue;
    out.poses.push_back({output.pose_ns(), output.T_map_body()});
    out.world_poses.push_back({output.pose_ns(), output.estimate.T_world_body});
    if (!output.estimate.keyframe) continue;
    for (MapFeature feature : runner.map()) {
      feature.start = output.S_map_world * feature.start;
      feature.end = output.S_map_world * feature.end;
      out.map.insert_or_assign({feature.kind, feature.id}, feature);
    }
  }
  out.summary = runner.map_summary();
  if (out.summary) out.contents = io::map_of_bytes(runner.saved_map(), "map");
  return out;
}

/// Every n-th of the features, so that at most so many remain; points of the map where there is one.
nlohmann::json json_of_features(const Observed& observed, const pl::Sim3<double>& S_truth_map) {
  constexpr std::size_t max_points = 3000, max_segments = 800;
  std::vector<std::vector<double>> points, segments;
  for (const auto& [id, feature] : observed.map) {
    const pl::Vec<double, 3> p = S_truth_map * feature.start, q = S_truth_map * feature.end;
    if (feature.is_line)
      segments.push_back({p.x(), p.y(), p.z(), q.x(), q.y(), q.z()});
    else
      points.push_back({p.x(), p.y(), p.z()});
  }
  const auto thinned = [](const std::vector<std::vector<double>>& all, std::size_t max) {
    nlohmann::json out = nlohmann::json::array();
    for (std::size_t i = 0, step = all.size() / max + 1; i < all.size(); i += step) out.push_back(rounded(all[i], 3));
    return out;
  };
  return {{"points",
           observed.summary ? json_of_points(observed.contents, max_points, S_truth_map) : thinned(points, max_points)},
          {"segments", thinned(segments, max_segments)}};
}

/// Positions of the camera in the world of the truth, and the error of what was estimated.
nlohmann::json json_of_trajectory(const io::Evaluation& result, const io::Trajectory& truth, const Needs& needs,
                                  const CompareJob& job, const io::Recording& recording) {
  constexpr std::size_t max_poses = 2000;
  std::map<pl::TimeNs, double> errors;
  for (const io::PosePair& pair : io::associate(truth, result.aligned, max_difference_s))
    errors[pair.t_ns] = (pair.reference.p() - pair.estimate.p()).norm();
  const pl::SE3<double> T_body_camera =
      needs.imu ? recording.calibration().T_body_camera.value() : pl::SE3<double>();  // body = camera without an IMU
  PositionSeries series;
  std::vector<double> error;
  for (std::size_t i = 0, step = result.aligned.size() / max_poses + 1; i < result.aligned.size(); i += step) {
    const io::StampedPose& pose = result.aligned[i];
    series.add(pl::seconds_between(job.dataset->frames.front(), pose.t_ns), (pose.T_world_body * T_body_camera).p());
    const auto found = errors.find(pose.t_ns);
    error.push_back(found == errors.end() ? std::nan("") : found->second);
  }
  nlohmann::json out = series.json();
  out["error"] = rounded(error, 5);
  return out;
}

void judge(const CompareJob& job, const io::Recording& recording, const Observed& observed, nlohmann::json& run) {
  const Needs& needs = job.configuration->needs;
  const io::Trajectory truth = recording.read_groundtruth(needs.imu).value();
  const io::EvaluationSettings settings{io::alignment_named(alignment_of(needs)).value(), max_difference_s, 1,
                                        io::DeltaUnit::seconds};
  const io::Evaluation result = io::evaluate_trajectory(truth, observed.poses, settings);
  const std::size_t with_truth =
      io::associate_times(io::times_of(recording.frames()), io::times_of(truth), std::llround(1e9 * max_difference_s))
          .size();
  run["compared"] = result.pairs;
  run["coverage"] = rounded(static_cast<double>(result.pairs) / static_cast<double>(with_truth), 4);
  if (settings.alignment == io::Alignment::sim3)
    run["scale"] = rounded(result.scale, 6);
  else
    run["scale_error"] = rounded(result.scale - 1, 6);
  const io::Statistics& ate = result.ape.translation;
  const auto json_of_ate = [](const io::Statistics& errors) -> nlohmann::json {
    return {{"rmse", rounded(errors.rmse, 6)}, {"median", rounded(errors.median, 6)}, {"max", rounded(errors.max, 6)}};
  };
  run["ate"] = json_of_ate(ate);
  if (observed.summary) {
    const io::Trajectory poses = final_trajectory(observed.world_poses, observed.summary->corrections);
    run["ate_final"] = json_of_ate(io::evaluate_trajectory(truth, poses, settings).ape.translation);
  }
  if (result.rpe.translation.count > 0)
    run["rpe_1s"] = {{"translation_rmse", rounded(result.rpe.translation.rmse, 6)},
                     {"rotation_rmse_deg", rounded(result.rpe.rotation_deg.rmse, 5)}};
  run["trajectory"] = json_of_trajectory(result, truth, needs, job, recording);
  const auto S = io::align(io::associate(truth, observed.poses, max_difference_s), settings.alignment);
  run["map"] = json_of_features(observed, S.value());
  run["status"] = "ok";
}

}  // namespace

const char* alignment_of(const Needs& needs) { return needs.imu ? "posyaw" : needs.depth ? "se3" : "sim3"; }

nlohmann::json json_of(const CompareJob& job) {
  return {{"configuration", job.configuration->name},
          {"dataset", job.dataset->name},
          {"repeat", job.repeat},
          {"with_map", job.with_map},
          {"first_frame", job.repeat},
          {"status", "failed"},
          {"error", ""},
          {"causal", true},
          {"alignment", alignment_of(job.configuration->needs)},
          {"scale", 1},
          {"scale_error", nullptr},
          {"frames", job.frames()},
          {"poses", 0},
          {"compared", 0},
          {"coverage", 0},
          {"ate", nullptr},
          {"rpe_1s", nullptr},
          {"health", nullptr},
          {"start_s", nullptr},
          {"time_ms", nullptr}};
}

CompareRun run_compared(const CompareJob& job) {
  cv::setNumThreads(1);  // decoding must not disturb the runs beside this one
  io::Recording recording = job.dataset->inputs.open(job.dataset->directory, job.begin_s, job.duration_s);
  const std::unique_ptr<Runner> runner = job.configuration->make(recording.calibration(), job.with_map);
  const Observed observed = observe(job, recording, *runner);

  CompareRun out{json_of(job), runner->bytes()};
  nlohmann::json& run = out.json;
  run["frames"] = observed.frames.t.size();
  run["poses"] = observed.poses.size();
  run["health"] = {{"initializing", observed.health[0]},
                   {"tracking", observed.health[1]},
                   {"degraded", observed.health[2]},
                   {"lost", observed.health[3]},
                   {"resets", observed.resets}};
  run["time_ms"] = {{"median", rounded(median(observed.times_ms), 3)},
                    {"p99", rounded(percentile(observed.times_ms, 0.99), 3)},
                    {"max", rounded(percentile(observed.times_ms, 1), 3)},
                    {"cpu_median", rounded(median(observed.cpu_ms), 3)}};
  if (observed.summary) {
    run["map_counts"] = json_of_counts(*observed.summary);
    for (const auto& [name, ms] : observed.frames.map_stages()) {
      std::vector<double> known;
      std::copy_if(ms->begin(), ms->end(), std::back_inserter(known), [](double each) { return !std::isnan(each); });
      const double mean = known.empty() ? std::nan("") : std::reduce(known.begin(), known.end()) / double(known.size());
      run["time_ms"]["map"][name] = {{"mean", rounded(mean, 4)}, {"max", rounded(percentile(known, 1), 3)}};
    }
  }
  run["frame_series"] = observed.frames.json(job.with_map);
  if (observed.poses.empty()) {
    run["error"] = "no pose in " + std::to_string(observed.frames.t.size()) + " frames";
    return out;
  }
  run["start_s"] = rounded(pl::seconds_between(recording.frames().front().t_ns, observed.poses.front().t_ns), 3);
  try {
    judge(job, recording, observed, run);
  } catch (const std::runtime_error& error) {
    run["error"] = error.what();
  }
  return out;
}
