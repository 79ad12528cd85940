#include "compare_plan.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "compare_json.hpp"
#include "format.hpp"
#include "misuse.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/io/text.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;
namespace fs = std::filesystem;

namespace {

bool is_pattern(const std::string& name) { return name.find_first_of("*?[") != std::string::npos; }

bool is_known(const std::vector<const Configuration*>& known, const Configuration& configuration) {
  return std::any_of(known.begin(), known.end(), [&](const Configuration* each) {
    return each == &configuration || each->make == configuration.make;
  });
}

/// A pattern takes each estimator once, whatever its names are.
std::vector<const Configuration*> configurations_named(const std::vector<std::string>& names) {
  std::vector<const Configuration*> out;
  for (const std::string& name : names) {
    if (!is_pattern(name)) {
      const Configuration* named = &configuration_named(name);
      if (std::find(out.begin(), out.end(), named) == out.end()) out.push_back(named);
      continue;
    }
    bool matches = false;
    for (const Configuration& configuration : configurations()) {
      if (fnmatch(name.c_str(), configuration.name, 0) != 0) continue;
      matches = true;
      if (!is_known(out, configuration)) out.push_back(&configuration);
    }
    if (!matches) throw Misuse("no configuration matches \"" + name + "\", see plumbline list");
  }
  return out;
}

/// Names, sizes and times of all files of a folder, or of those that are read with a bag.
std::string content_of(const fs::path& directory, const io::Recording& recording, const TopicOptions& topics) {
  std::map<std::string, std::string> files;
  const auto add = [&](const fs::directory_entry& entry) {
    if (!entry.is_regular_file()) return;
    const auto ticks = static_cast<long long>(entry.last_write_time().time_since_epoch().count());
    files[entry.path().string()] = std::to_string(entry.file_size()) + " " + std::to_string(ticks);
  };
  if (recording.files().bag.empty())
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(directory)) add(entry);
  else
    for (const fs::path& file : recording.inputs()) add(fs::directory_entry(file));
  std::string text = topics.image + " " + topics.depth + " " + topics.imu + " " + topics.camera_info + "\n";
  for (const auto& [name, state] : files) text.append(name).append(" ").append(state).append("\n");
  return fingerprint(text);
}

/// Where the camera truly was while the frames were taken. What is drawn of all configurations are positions of the
/// camera: those with an IMU estimate the body.
nlohmann::json json_of_truth(const io::Recording& recording, const std::vector<pl::TimeNs>& frames) {
  constexpr std::size_t max_poses = 2000;
  io::Trajectory truth = recording.read_groundtruth(recording.has_imu()).value();
  if (recording.has_imu()) truth = moved_to(truth, recording.calibration().T_body_camera.value());
  constexpr pl::TimeNs margin_ns = 50'000'000;
  std::erase_if(truth, [&](const io::StampedPose& pose) {
    return pose.t_ns < frames.front() - margin_ns || pose.t_ns > frames.back() + margin_ns;
  });
  PositionSeries series;
  for (std::size_t i = 0, step = truth.size() / max_poses + 1; i < truth.size(); i += step)
    series.add(pl::seconds_between(frames.front(), truth[i].t_ns), truth[i].T_world_body.p());
  return series.json();
}

/// The texts of the files that are read beside the recording, and the options with them.
std::string content_of(const RecordingOptions& inputs) {
  std::string text;
  for (const auto& file : {inputs.calibration, inputs.imu_calibration, inputs.mask})
    text += (file ? io::read_text(*file) : std::string()) + '\n';
  return fingerprint(
      text + format("%.9g %.9g %.9g", inputs.depth_scale, inputs.time_offset_s.value_or(NAN), inputs.image_scale));
}

CompareDataset open_dataset(const fs::path& given, const CompareOptions& options, std::vector<std::string>& notes) {
  const fs::path directory = fs::weakly_canonical(given);
  const io::Recording recording = options.inputs.open(directory);
  notes.insert(notes.end(), recording.notes().begin(), recording.notes().end());
  for (const std::string& line : unusable_sensors(recording)) notes.push_back(line);
  const pl::TimeNs begin_ns = recording.frames().front().t_ns;
  CompareDataset out{directory,
                     directory.filename().string(),
                     recording.has_depth(),
                     recording.has_imu(),
                     begin_ns,
                     {},
                     {},
                     options.inputs,
                     {}};
  for (const io::FrameSample& frame : recording.frames()) {
    const double t_s = pl::seconds_between(begin_ns, frame.t_ns);
    if (t_s >= options.start_s && t_s <= options.start_s + options.duration_s) out.frames.push_back(frame.t_ns);
  }
  if (out.frames.size() <= options.repeats)
    throw std::runtime_error(format("%s: %zu frames in the part asked for, too few for %zu repeats", given.c_str(),
                                    out.frames.size(), options.repeats));
  if (!recording.groundtruth()) throw std::runtime_error(given.string() + " has no true trajectory to compare with");
  out.content = content_of(directory, recording, options.inputs.topics) + " " + content_of(options.inputs);
  const double duration_s = pl::seconds_between(out.frames.front(), out.frames.back());
  const io::CameraCalibration& camera = recording.calibration().camera;
  out.json = {{"name", out.name},
              {"frames", out.frames.size()},
              {"duration_s", rounded(duration_s, 3)},
              {"rate_hz", rounded(static_cast<double>(out.frames.size() - 1) / duration_s, 2)},
              {"width", camera.width},
              {"height", camera.height},
              {"has_depth", out.has_depth},
              {"has_imu", out.has_imu},
              {"truth", json_of_truth(recording, out.frames)}};
  return out;
}

/// What the recording lacks for this configuration; nothing where it has all.
std::string lacks(const Configuration& configuration, const CompareDataset& dataset) {
  const bool depth = configuration.needs.depth && !dataset.has_depth;
  const bool imu = configuration.needs.imu && !dataset.has_imu;
  return depth && imu ? "depth and an IMU" : depth ? "depth" : imu ? "an IMU" : "";
}

[[noreturn]] void throw_unserved(const Configuration& configuration, const std::vector<CompareDataset>& datasets) {
  throw std::runtime_error(std::string(configuration.name) + " can run on none of the recordings: " +
                           datasets.front().name + " lacks " + lacks(configuration, datasets.front()));
}

CompareJob job_of(const Configuration& configuration, const CompareDataset& dataset, std::size_t repeat,
                  bool with_map) {
  constexpr double margin_s = 1e-6;  // the last frame is in, whatever is rounded
  const pl::TimeNs first_ns = dataset.frames[repeat];
  return {&configuration,
          &dataset,
          repeat,
          pl::seconds_between(dataset.begin_ns, first_ns),
          pl::seconds_between(first_ns, dataset.frames.back()) + margin_s,
          with_map};
}

void check(const CompareOptions& options) {
  if (!(options.start_s >= 0) || !std::isfinite(options.start_s)) throw Misuse("--start must be a time of 0 s or more");
  if (!(options.duration_s > 0)) throw Misuse("--duration must be a time of more than 0 s");
  if (options.repeats == 0) throw Misuse("--repeat must be 1 or more");
}

}  // namespace

ComparePlan::ComparePlan(const CompareOptions& options) : configurations(configurations_named(options.configs)) {
  check(options);
  for (const fs::path& directory : options.datasets) {
    CompareDataset dataset = open_dataset(directory, options, notes);
    for (const CompareDataset& other : datasets)
      if (other.name == dataset.name)
        throw Misuse("two recordings are called " + dataset.name + ": " + other.directory.string() + " and " +
                     dataset.directory.string());
    datasets.push_back(std::move(dataset));
  }

  std::map<std::string, std::size_t> served;
  for (const CompareDataset& dataset : datasets) {
    std::map<std::string, std::size_t> counts;
    for (const Configuration* configuration : configurations) {
      const std::string missing = lacks(*configuration, dataset);
      if (missing.empty())
        ++served[configuration->name];
      else
        ++counts[missing];
    }
    for (const auto& [missing, count] : counts)
      left_out.push_back(dataset.name + " lacks " + missing + ": " + std::to_string(count) +
                         (count == 1 ? " configuration" : " configurations") + " left out");
  }
  for (const std::string& name : options.configs)
    if (!is_pattern(name) && served[name] == 0) throw_unserved(configuration_named(name), datasets);
  for (const Configuration* configuration : configurations) {
    for (const CompareDataset& dataset : datasets) {
      if (!lacks(*configuration, dataset).empty()) continue;
      for (std::size_t repeat = 0; repeat < options.repeats; ++repeat)
        jobs.push_back(job_of(*configuration, dataset, repeat, options.with_map));
    }
  }
  if (jobs.empty()) throw_unserved(*configurations.front(), datasets);
}

nlohmann::json json_of(const Configuration& configuration) {
  std::string parts;
  for (const Configuration& each : configurations())
    if (each.make == configuration.make &&
        std::count(each.name, each.name + std::string_view(each.name).size(), '/') == 2)
      parts = each.name;
  const std::size_t first = parts.find('/'), last = parts.rfind('/');
  return {{"name", configuration.name},
          {"sensors", parts.substr(0, first)},
          {"features", parts.substr(first + 1, last - first - 1)},
          {"backend", parts.substr(last + 1)},
          {"bytes", nullptr}};
}
