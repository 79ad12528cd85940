#include "run.hpp"

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "format.hpp"
#include "images.hpp"
#include "interrupt.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "progress.hpp"
#include "recording_check.hpp"
#include "run_map.hpp"
#include "run_tally.hpp"
#include "runner.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;

namespace {

/// Prints all findings; throws the last error among them, unless the recording is used unchecked.
void require_plausible(const pl::io::Recording& recording, const Needs& needs, bool is_unchecked) {
  std::string error;
  const auto print = [](const char* kind, const std::string& text) {
    std::fprintf(stderr, "plumbline: %s%s\n", kind, pl::io::printable(text).c_str());
  };
  for (const Finding& finding : check_recording(recording, needs)) {
    if (!finding.is_error || is_unchecked) {
      print("warning: ", finding.text);
      continue;
    }
    if (!error.empty()) print("", error);
    error = finding.text;
  }
  if (!error.empty()) throw std::runtime_error(error);
}

std::vector<std::filesystem::path> inputs_of(const pl::io::Recording& recording, const RunOptions& options) {
  std::vector<std::filesystem::path> inputs = recording.inputs();
  if (options.debug.reference) inputs.push_back(*options.debug.reference);
  if (options.loaded_map && options.loaded_map != options.files.map) inputs.push_back(*options.loaded_map);
  return inputs;
}

std::optional<DebugReport> open_debug(const RunOptions& options, const Configuration& configuration,
                                      const pl::io::Recording& recording) {
  if (options.debug.directory.empty()) return std::nullopt;
  const pl::io::Trajectory truth =
      options.debug.reference ? pl::io::read_trajectory(*options.debug.reference)
                              : recording.read_groundtruth(configuration.needs.imu).value_or(pl::io::Trajectory());
  return std::make_optional<DebugReport>(options.debug,
                                         std::string(configuration.name) + " on " + options.dataset.string(), truth);
}

}  // namespace

int run_configuration(const RunOptions& options) {
  const Configuration* named = options.config.empty() ? nullptr : &configuration_named(options.config);
  pl::io::Recording recording = options.inputs.open(options.dataset, options.start_s, options.duration_s);
  const Configuration& configuration = named ? *named : recommended_for({recording.has_depth(), recording.has_imu()});
  require_sensors(configuration, recording, options.dataset);

  const Interruptible interruptible;
  RunFiles files(options.files, inputs_of(recording, options));
  require_plausible(recording, configuration.needs, options.is_unchecked);
  print_notes(recording.notes());
  print_notes(unused_sensors(recording, configuration));
  if (!named) std::fprintf(stderr, "configuration: %s\n", why_recommended(configuration, recording).c_str());
  std::optional<DebugReport> debug = open_debug(options, configuration, recording);

  const bool with_map = options.with_map || options.loaded_map || options.files.map;
  const std::unique_ptr<Runner> runner = configuration.make(recording.calibration(), {with_map, options.localize_only});
  if (options.loaded_map) load_map(*options.loaded_map, *runner);
  RunTally tally;
  Progress progress(configuration.name, recording.frame_count());
  pl::io::Recording::Sample sample;
  bool found_map = !options.loaded_map;
  for (; recording.next(sample, runner->time_offset_s()); progress.show(tally.read())) {
    if (const pl::ImuSample* imu = std::get_if<pl::ImuSample>(&sample)) {
      if (configuration.needs.imu) runner->add_imu(*imu);
      continue;
    }
    if (Interruptible::is_asked_to_stop())
      throw Interrupted(format("interrupted after %zu of %zu frames; ", tally.read(), recording.frame_count()) +
                        (debug ? options.debug.directory.string() + " is incomplete" : "nothing was written"));
    const pl::io::FrameSample& frame = std::get<pl::io::FrameSample>(sample);
    Images images;
    try {
      images = read_images(frame, configuration.needs.depth);
    } catch (const std::runtime_error& damage) {
      tally.skip();
      progress.note(std::string("skipped: ") + damage.what());
      continue;
    }
    if (tally.is_first()) require_calibrated_size(frame, images, recording.calibration().camera);
    const FrameOutput output = runner->add_frame(frame.t_ns, images.gray, images.depth);
    const bool is_in_trajectory = options.all_poses ? output.has_pose() : output.has_sound_pose();
    found_map = found_map || (is_in_trajectory && output.is_in_map);
    tally.add(output, is_in_trajectory);
    if (output.refused) progress.note("refused: " + frame.image.string() + ": " + name_of(*output.refused));
    if (is_in_trajectory) files.add_pose(output.pose_ns(), output);
    files.add_timing(frame.t_ns, output);
    if (files.has_states()) files.add_state(frame.t_ns, output, runner->inspect());
    if (debug) debug->add(tally.read() - 1, frame.t_ns, images.gray, output, runner->inspect());
  }
  const std::string wrong = found_wrong(recording.calibration(), runner->inspect());
  if (files.has_landmarks()) files.add_landmarks(runner->landmarks());
  const std::optional<MapSummary> map = runner->map_summary();
  std::vector<std::byte> saved;
  if (map && (debug || files.has_map())) saved = runner->saved_map();
  if (debug)
    debug->finish(tally.summary() + (map ? '\n' + summary_of(*map) : ""), map,
                  map ? pl::io::map_of_bytes(saved, "map") : pl::io::MapContents());
  const std::string why =
      options.dataset.string() + ": " + tally.why_no_pose() +
      (debug ? "; see " + (options.debug.directory / "report.html").string()
             : "; --debug DIR shows each of them, plumbline doctor DIR what is wrong with the recording");
  if (tally.poses() == 0) {
    std::fputs(wrong.c_str(), stdout);
    files.commit_tables();
    throw std::runtime_error(why);
  }
  files.add_final(map ? map->corrections : std::vector<MapCorrection>());
  files.add_loops(map ? map->loops : std::vector<MapLoop>());
  if (files.has_map()) files.add_map(saved);
  files.commit_all();
  if (!found_map)
    print_notes({not_found_in(*options.loaded_map) + "; --trajectory-world has the poses in the run's own world"});
  std::vector<std::string> warnings;
  if (tally.is_never_tracking()) {
    if (configuration.needs.imu) warnings = excess_of_stated_noise(recording);
    if (!tally.is_mostly_without()) warnings.push_back(tally.why_never_tracking());
  }
  for (const std::string& warning : warnings)
    progress.note("plumbline: warning: " + options.dataset.string() + ": " + warning);
  if (tally.is_mostly_without()) progress.note("plumbline: warning: " + why);
  std::puts(tally.summary().c_str());
  if (!options.files.trajectory) std::puts("no trajectory is written (--trajectory FILE)");
  if (map) std::puts(summary_of(*map).c_str());
  if (options.files.timing) std::fputs(tally.times().c_str(), stdout);
  std::fputs(wrong.c_str(), stdout);
  return 0;
}
