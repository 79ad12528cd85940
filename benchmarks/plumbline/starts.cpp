#include "starts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "plumbline/io/trajectory_alignment.hpp"
#include "statistics.hpp"
#include "trial.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

struct StartOutcome {
  double pose_s = never, tracking_s = never;  ///< after the first frame
  double scale_error = NAN, later = NAN;      ///< over two seconds from `tracking` on, and of the last two; NaN at rest
  int wrong = 0;                              ///< frames
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
    out.wrong += frame.is_false();
  }
  if (tracking_ns == 0) return out;
  out.scale_error = scale_error(recording, frames, tracking_ns, tracking_ns + two_s);
  out.later = scale_error(recording, frames, frames.back().t_ns - two_s, frames.back().t_ns);
  return out;
}

void print_number(double x, double unit, int digits) {
  if (std::isfinite(x))
    std::printf(" %8.*f", digits, x * unit);
  else
    std::printf(" %8s", "-");
}

void run_starts(const Configuration& configuration, const LoadedRecording& recording, const StartOptions& options) {
  std::printf("%s on %s\n%8s %8s %8s %8s %8s %8s  %s\n", configuration.name, recording.name.c_str(), "begin s",
              "pose s", "track s", "scale %", "later %", "false", "last health");
  int starts = 0, posed = 0, tracked = 0, wrong = 0;
  std::vector<double> pose_s, scales, later;
  const double length_s = pl::seconds_between(recording.begin_ns, recording.end_ns);
  for (double begin_s = 0; begin_s + options.duration_s <= length_s; begin_s += options.every_s) {
    const pl::TimeNs begin_ns = recording.begin_ns + std::llround(1e9 * begin_s);
    const pl::TimeNs end_ns = begin_ns + std::llround(1e9 * options.duration_s);
    const auto frames = run_trial(configuration, recording, begin_ns, end_ns, [](Event&) { return true; }).frames;
    if (frames.empty()) continue;
    const StartOutcome out = outcome_of(recording, frames);
    ++starts;
    posed += std::isfinite(out.pose_s);
    tracked += std::isfinite(out.tracking_s);
    wrong += out.wrong > 0;
    pose_s.push_back(out.pose_s);
    if (std::isfinite(out.scale_error)) scales.push_back(out.scale_error);
    if (std::isfinite(out.later)) later.push_back(out.later);
    std::printf("%8.1f", begin_s);
    print_number(out.pose_s, 1, 2);
    print_number(out.tracking_s, 1, 2);
    print_number(out.scale_error, 100, 1);
    print_number(out.later, 100, 1);
    const pl::Health& health = frames.back().estimate.health;
    std::printf(" %8d  %s, %s\n", out.wrong, name_of(health.state), name_of(health.reason));
    std::fflush(stdout);
  }
  const auto worst = [](const std::vector<double>& x) {
    return x.empty() ? NAN : *std::max_element(x.begin(), x.end());
  };
  std::printf(
      "%d starts: %d with a pose (median %.2f s), %d tracking, %d falsely; scale error median %.1f %%, worst "
      "%.1f %%, later %.1f %% and %.1f %%\n",
      starts, posed, median(pose_s), tracked, wrong, 100 * median(scales), 100 * worst(scales), 100 * median(later),
      100 * worst(later));
}

}  // namespace

int run_starts(const StartOptions& options) {
  for (const std::string& name : options.configs) {
    const Configuration& configuration = configuration_named(name);
    for (const auto& dataset : options.datasets)
      run_starts(configuration, load_recording(dataset, configuration.needs), options);
  }
  return 0;
}
