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
#include "plumbline/io/printable.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "progress.hpp"
#include "recording_check.hpp"
#include "run_tally.hpp"
#include "runner.hpp"

namespace pl = plumbline;

namespace {

/// A calibration for another resolution would give wrong poses without an error.
void require_calibrated_size(const pl::io::FrameSample& frame, const Images& images,
                             const pl::io::CameraCalibration& camera) {
  pl::opencv::require_resolution(images.gray, camera.width, camera.height, frame.image);
  if (!images.depth.empty()) pl::opencv::require_resolution(images.depth, camera.width, camera.height, *frame.depth);
}

void require_sensors(const Configuration& configuration, const pl::io::Recording& recording,
                     const std::filesystem::path& dataset) {
  if (configuration.needs.depth && !recording.has_depth())
    throw std::runtime_error(dataset.string() + ": " + configuration.name +
                             " needs depth images and the calibration's depth scale");
  if (configuration.needs.imu && !recording.has_imu())
    throw std::runtime_error(dataset.string() + ": " + configuration.name +
                             " needs IMU samples, their noise and T_body_camera");
}

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
  pl::io::Recording recording = pl::io::Recording::open(
      options.dataset,
      {.calibration = options.calibration, .start_s = options.start_s, .duration_s = options.duration_s});
  const Configuration& configuration = named ? *named : recommended_for({recording.has_depth(), recording.has_imu()});
  require_sensors(configuration, recording, options.dataset);

  const Interruptible interruptible;
  RunFiles files(options.files, inputs_of(recording, options));
  require_plausible(recording, configuration.needs, options.is_unchecked);
  if (!named) std::fprintf(stderr, "configuration: %s\n", configuration.name);
  std::optional<DebugReport> debug = open_debug(options, configuration, recording);

  const std::unique_ptr<Runner> runner = configuration.make(recording.calibration());
  RunTally tally;
  Progress progress(configuration.name, recording.frame_count());
  pl::io::Recording::Sample sample;
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
    tally.add(output, is_in_trajectory);
    if (output.refused) progress.note("refused: " + frame.image.string() + ": " + name_of(*output.refused));
    if (is_in_trajectory) files.add_pose(output.pose_ns(), output);
    files.add_timing(frame.t_ns, output);
    if (files.has_states()) files.add_state(frame.t_ns, output, runner->inspect());
    if (debug) debug->add(tally.read() - 1, frame.t_ns, images.gray, output, runner->inspect());
  }
  if (debug) debug->finish(tally.summary());
  const std::string why =
      options.dataset.string() + ": " + tally.why_no_pose() +
      (debug ? "; see " + (options.debug.directory / "report.html").string() : "; --debug DIR shows each of them");
  const std::string wrong = found_wrong(recording.calibration(), runner->inspect());
  if (tally.poses() == 0) {
    std::fputs(wrong.c_str(), stdout);
    files.commit_tables();
    throw std::runtime_error(why);
  }
  if (files.has_landmarks()) files.add_landmarks(runner->landmarks());
  files.commit_all();
  if (tally.is_mostly_without()) progress.note("plumbline: warning: " + why);
  std::puts(tally.summary().c_str());
  if (options.files.timing) std::fputs(tally.times().c_str(), stdout);
  std::fputs(wrong.c_str(), stdout);
  return 0;
}
