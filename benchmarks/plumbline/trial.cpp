#include "trial.hpp"

#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>

#include "open_recording.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/recording.hpp"
#include "truth_comparison.hpp"
#include "unused_sensors.hpp"

namespace pl = plumbline;

LoadedRecording load_recording(const std::filesystem::path& directory, const Configuration& configuration,
                               const RecordingOptions& inputs) {
  pl::io::Recording recording = inputs.open(directory);
  const Needs& needs = configuration.needs;
  require_sensors(configuration, recording, directory);
  const auto require = [&](bool there, const char* what) {
    if (!there) throw std::runtime_error(directory.string() + " has no " + what);
  };
  const auto truth = recording.read_groundtruth(needs.imu);
  require(truth.has_value(), "true trajectory");
  LoadedRecording out{
      pl::io::printable(directory.filename().string()), recording.calibration(), *truth, {}, recording.notes()};
  for (const std::string& line : unused_sensors(recording, configuration)) out.notes.push_back(line);
  pl::io::Recording::Sample sample;
  while (recording.next(sample)) {
    if (const auto* imu = std::get_if<pl::ImuSample>(&sample)) {
      if (needs.imu) out.events.emplace_back(*imu);
      continue;
    }
    const auto& frame = std::get<pl::io::FrameSample>(sample);
    Picture picture{frame.t_ns, pl::io::read_gray(frame), {}};
    if (needs.depth && frame.depth) picture.depth = pl::io::read_depth(frame);
    out.events.emplace_back(picture);
  }
  require(recording.frame_count() > 0, "frames");
  out.begin_ns = recording.frames().front().t_ns;
  out.end_ns = recording.frames().back().t_ns;
  return out;
}

bool JudgedFrame::is_false() const {
  constexpr double limit = 3.762;  // square root of 14.16
  return estimate.health.state == pl::HealthState::tracking && (position_sigmas > limit || rotation_sigmas > limit);
}

void run_events(Runner& runner, const LoadedRecording& recording, pl::TimeNs begin_ns, pl::TimeNs end_ns,
                const Spoil& spoil, const std::function<void(const FrameOutput&)>& use) {
  std::deque<Picture> waiting;  // for IMU samples, where the time offset is positive
  const auto use_first = [&] {
    const Picture& picture = waiting.front();
    use(runner.add_frame(picture.t_ns, picture.gray, picture.depth));
    waiting.pop_front();
  };
  for (Event event : recording.events) {
    const auto t_ns = std::visit([](const auto& e) { return e.t_ns; }, event);
    if (t_ns < begin_ns || t_ns > end_ns + 20'000'000 || !spoil(event)) continue;
    if (const auto* imu = std::get_if<pl::ImuSample>(&event))
      runner.add_imu(*imu);
    else if (t_ns <= end_ns)
      waiting.push_back(std::get<Picture>(event));
    while (!waiting.empty() && waiting.front().t_ns + std::llround(1e9 * runner.time_offset_s()) <= t_ns) use_first();
  }
  while (!waiting.empty()) use_first();
}

Trial run_trial(const Configuration& configuration, const LoadedRecording& recording, pl::TimeNs begin_ns,
                pl::TimeNs end_ns, const Spoil& spoil, const std::optional<pl::SO3<double>>& heading) {
  const auto runner = configuration.make(recording.calibration, recording.with_map);
  std::vector<JudgedFrame> frames;
  std::vector<EstimatedPose> poses;
  run_events(*runner, recording, begin_ns, end_ns, spoil, [&](const FrameOutput& output) {
    if (output.refused) return;
    frames.push_back({output.pose_ns(), output.estimate, std::nan(""), std::nan(""), std::nan("")});
    if (output.has_sound_pose()) poses.push_back({output.pose_ns(), output.T_map_body(), output.estimate.covariance});
  });
  std::size_t next = 0;
  const TruthComparison comparison = compare_with_truth(recording.truth, poses, configuration.needs.imu, heading);
  for (const TruthError& each : comparison.errors) {
    while (frames[next].t_ns != each.t_ns) ++next;
    frames[next].error_m = each.error.tail<3>().norm();
    frames[next].position_sigmas = std::sqrt(each.nees_position);
    frames[next].rotation_sigmas = std::sqrt(each.nees_rotation);
  }
  return {frames, comparison.heading};
}

double ate_of(const std::vector<JudgedFrame>& frames) {
  double sum = 0;
  int n = 0;
  for (const JudgedFrame& frame : frames) {
    if (!std::isfinite(frame.error_m)) continue;
    sum += frame.error_m * frame.error_m;
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : std::nan("");
}
