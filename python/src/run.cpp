#include "run.hpp"

#include <memory>
#include <stdexcept>
#include <variant>

#include <pybind11/pybind11.h>

#include "images.hpp"
#include "plumbline/io/recording.hpp"
#include "recording_check.hpp"
#include "run_tally.hpp"
#include "runner.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;
namespace py = pybind11;

namespace {

void require_plausible(const pl::io::Recording& recording, const Needs& needs, bool is_unchecked,
                       std::vector<std::string>& notes) {
  std::string errors;
  for (const Finding& finding : check_recording(recording, needs)) {
    if (!finding.is_error || is_unchecked)
      notes.push_back("warning: " + finding.text);
    else
      errors += (errors.empty() ? "" : "; ") + finding.text;
  }
  if (!errors.empty()) throw std::runtime_error(errors);
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Throws what Python's handler of a signal throws.
void check_signals() {
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

}  // namespace

PythonRun run_recording(const std::filesystem::path& dataset, const PythonRunOptions& options) {
  const py::gil_scoped_release release;
  const Configuration* named = options.config.empty() ? nullptr : &configuration_named(options.config);
  pl::io::Recording recording = options.inputs.open(dataset, options.start_s, options.duration_s);
  const Configuration& configuration = named ? *named : recommended_for({recording.has_depth(), recording.has_imu()});
  require_sensors(configuration, recording, dataset);

  PythonRun out;
  out.config = configuration.name;
  require_plausible(recording, configuration.needs, options.is_unchecked, out.notes);
  append(out.notes, recording.notes());
  append(out.notes, unused_sensors(recording, configuration));
  const std::unique_ptr<Runner> runner = configuration.make(recording.calibration(), options.with_map);
  const pl::io::CameraCalibration& camera = recording.calibration().camera;
  RunTally tally;
  pl::io::Recording::Sample sample;
  while (recording.next(sample, runner->time_offset_s())) {
    if (const pl::ImuSample* imu = std::get_if<pl::ImuSample>(&sample)) {
      if (configuration.needs.imu) runner->add_imu(*imu);
      continue;
    }
    check_signals();
    const pl::io::FrameSample& frame = std::get<pl::io::FrameSample>(sample);
    Images images;
    try {
      images = read_images(frame, configuration.needs.depth);
    } catch (const std::runtime_error& damage) {
      tally.skip();
      out.notes.push_back(std::string("skipped: ") + damage.what());
      continue;
    }
    if (tally.is_first()) require_calibrated_size(frame, images, camera);
    const FrameOutput output = runner->add_frame(frame.t_ns, images.gray, images.depth);
    const bool is_in_trajectory = options.all_poses ? output.has_pose() : output.has_sound_pose();
    tally.add(output, is_in_trajectory);
    if (output.refused) out.notes.push_back("refused: " + frame.image.string() + ": " + name_of(*output.refused));
    if (is_in_trajectory && output.is_in_map) out.trajectory.push_back({output.pose_ns(), output.T_map_body()});
  }
  if (tally.poses() == 0) throw std::runtime_error(dataset.string() + ": " + tally.why_no_pose());
  if (tally.is_mostly_without()) out.notes.push_back("warning: " + dataset.string() + ": " + tally.why_no_pose());
  out.landmarks = runner->landmarks();
  out.summary = tally.summary();
  return out;
}
