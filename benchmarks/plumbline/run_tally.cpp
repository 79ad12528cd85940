#include "run_tally.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "format.hpp"
#include "plumbline/initialization/two_view.hpp"
#include "statistics.hpp"

namespace pl = plumbline;

namespace {

/// The condition that initialization waits for, with measured and required values.
std::string figures_of(const pl::InitReport& start) {
  const pl::TwoViewInitializerOptions two_view;
  switch (start.stage) {
    case pl::InitStage::few_features: return format("%d in sight", start.features);
    case pl::InitStage::little_parallax:
      return format("%.2g degrees of %.2g, %d features: the camera must move sideways", degrees * start.parallax_rad,
                    degrees * two_view.min_parallax_rad, start.features);
    case pl::InitStage::two_views_disagree:
      return format("%.0f %% of %d features fit one motion, %.0f needed: is the calibration right?",
                    100 * start.inliers, start.features, 100 * two_view.min_inliers);
    case pl::InitStage::rejected:
      return format(
          "%d initializations: images and IMU fit only with implausible biases; are the units and axes of the "
          "IMU, the time offset and T_body_camera right?",
          start.rejected);
    case pl::InitStage::done: return {};
    case pl::InitStage::aligning: break;
  }
  switch (start.alignment) {
    case pl::AlignmentOutcome::rotations_disagree:
      return format("by %.2g degrees: are axes, units, time offset and T_body_camera right?",
                    degrees * start.gyro_residual);
    case pl::AlignmentOutcome::gravity_implausible:
      return format("%.3g m/s^2: are units, axes and T_body_camera right?", start.gravity_norm);
    case pl::AlignmentOutcome::positions_disagree:
      return "feature tracking is poor, or the time offset or T_body_camera is wrong";
    case pl::AlignmentOutcome::gravity_uncertain:
    case pl::AlignmentOutcome::scale_uncertain:
      return format("to %.0f %%, motion of %.2g m/s^2: the body must move with more acceleration",
                    100 * start.scale_sigma, start.excitation);
    case pl::AlignmentOutcome::too_few_frames:
      return format("%d features in sight: the recording, or each stretch of tracking, is too short", start.features);
    default: return format("%d features in sight", start.features);
  }
}

/// Initializes, at first or after a reset.
bool is_initializing(const FrameOutput& output) {
  return output.health() == pl::HealthState::initializing ||
         (output.health() == pl::HealthState::lost && output.start.stage != pl::InitStage::done);
}

std::string explanation_of(const FrameOutput& output) {
  if (output.refused) return std::string("refused, ") + name_of(*output.refused);
  const pl::Health& health = output.estimate.health;
  if (!is_initializing(output)) return std::string(name_of(health.state)) + ", " + name_of(health.reason);
  if (health.reason != pl::HealthReason::aligning && health.reason != pl::HealthReason::none)
    return name_of(health.reason);
  return output.start.stage == pl::InitStage::aligning ? name_of(output.start.alignment) : name_of(output.start.stage);
}

}  // namespace

void RunTally::add(const FrameOutput& output, bool is_in_trajectory) {
  ++read_;
  total_ms_.push_back(1e3 * output.timing.total);
  poses_ += is_in_trajectory;
  refused_ += output.refused.has_value();
  if (!output.refused) {
    ++by_health_[static_cast<std::size_t>(output.health())];
    resets_ = std::max(resets_, output.estimate.resets);
  }
  if (output.has_sound_pose()) {
    ++sound_reasons_[explanation_of(output)];
    map_.push_back(output.map_timing);
    return sound_.push_back(output.timing);
  }
  ++without_;
  Reason& reason = reasons_[explanation_of(output)];
  ++reason.frames;
  if (!output.refused && is_initializing(output)) reason.figures = figures_of(output.start);
}

std::string RunTally::summary() const {
  std::vector<double> ms = total_ms_;
  std::sort(ms.begin(), ms.end());
  const auto count = [&](pl::HealthState state) { return by_health_[static_cast<std::size_t>(state)]; };
  return format(
      "%zu frames: %zu poses, %zu tracking, %zu degraded, %zu lost, %zu initializing, %zu skipped, %zu "
      "refused; %u resets; median %.2f ms, longest %.2f ms",
      read_, poses_, count(pl::HealthState::tracking), count(pl::HealthState::degraded), count(pl::HealthState::lost),
      count(pl::HealthState::initializing), skipped_, refused_, resets_, ms.empty() ? 0 : ms[ms.size() / 2],
      ms.empty() ? 0 : ms.back());
}

std::string RunTally::times() const {
  std::string out = format("%-32s%8s%8s%8s%8s\n", format("%zu frames with a pose [ms]", sound_.size()).c_str(), "mean",
                           "median", "99 %", "longest");
  const auto add = [&](const char* name, auto stage, const auto& frames) {
    std::vector<double> ms;
    for (const auto& timing : frames) ms.push_back(1e3 * std::invoke(stage, timing));
    const double mean = std::reduce(ms.begin(), ms.end()) / static_cast<double>(ms.size());
    out += format("  %-30s%8.2f%8.2f%8.2f%8.2f\n", name, mean, median(ms), percentile(ms, 0.99), percentile(ms, 1));
  };
  using pl::FrameTiming;
  add("pyramid", &FrameTiming::pyramid, sound_);
  add("alignment of the image", &FrameTiming::align, sound_);
  add("alignment of features", &FrameTiming::follow, sound_);
  add("pose", &FrameTiming::estimate, sound_);
  add("map, keyframes", &FrameTiming::map, sound_);
  add("whole frame", &FrameTiming::total, sound_);
  if (std::all_of(map_.begin(), map_.end(), [](const MapTiming& timing) { return timing.total() == 0; })) return out;
  add("keyframe map: learn", &MapTiming::learn, map_);
  add("keyframe map: query", &MapTiming::query, map_);
  add("keyframe map: verify", &MapTiming::verify, map_);
  add("keyframe map: solve", &MapTiming::solve, map_);
  return out;
}

std::string RunTally::why_no_pose() const {
  const std::size_t none = without_ + skipped_;
  const std::string frames =
      none == read_ ? format("no pose in %zu frames", none) : format("no sound pose in %zu of %zu frames", none, read_);
  if (reasons_.empty()) return frames + ": no image can be used";
  const auto longest = std::max_element(reasons_.begin(), reasons_.end(),
                                        [](const auto& a, const auto& b) { return a.second.frames < b.second.frames; });
  const auto& [name, reason] = *longest;
  return frames + format(": %s in %zu of them", name.c_str(), reason.frames) +
         (reason.figures.empty() ? "" : " (" + reason.figures + ")");
}

bool RunTally::is_never_tracking() const {
  return !sound_.empty() && by_health_[static_cast<std::size_t>(pl::HealthState::tracking)] == 0;
}

std::string RunTally::why_never_tracking() const {
  const auto longest = std::max_element(sound_reasons_.begin(), sound_reasons_.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  return format("no frame is tracking: %s in %zu of %zu frames with a pose", longest->first.c_str(), longest->second,
                sound_.size());
}

std::string found_wrong(const pl::io::Calibration& calibration, const Inspection& last) {
  if (!last.inertial) return {};
  std::string out;
  const auto report_full_scale = [&](const char* sensor, double found, double declared, const char* unit) {
    if (!(found < declared)) return;
    out += format("calibration: %s_full_scale is %.4g %s, not %.4g; samples at that value count as saturated\n", sensor,
                  found, unit, declared);
  };
  const pl::ImuBufferOptions& limits = calibration.imu_limits;
  report_full_scale("gyroscope", last.inertial->gyro_full_scale, limits.gyro_full_scale, "rad/s");
  report_full_scale("accelerometer", last.inertial->accel_full_scale, limits.accel_full_scale, "m/s^2");
  const double later_s = last.inertial->time_offset_s;
  if (std::abs(later_s) > std::max(1e-3, 4 * last.inertial->sigma_time_offset_s))
    out += format("calibration: time_offset_s is %.4f, not %.4f; the run corrected it\n",
                  calibration.camera_time_offset_s + later_s, calibration.camera_time_offset_s);
  const char* done = last.inertial->corrects_extrinsics ? "the run corrected it" : "the run did not correct it";
  const auto differs = [&](const char* how, const pl::Vec<double, 3>& found, const pl::Vec<double, 3>& sigma,
                           double least, double unit, const char* unit_name) {
    constexpr double gate = 4;  // [sigma]
    if (!(found.norm() > least) || !((found.array().abs() > gate * sigma.array()).any())) return;
    const pl::Vec<double, 3> shown = unit * found;
    out += format("calibration: T_body_camera is %s by [%.1f %.1f %.1f] +- %.1f %s, in body axes; %s\n", how, shown.x(),
                  shown.y(), shown.z(), unit * sigma.maxCoeff(), unit_name, done);
  };
  differs("rotated", last.inertial->turned, last.inertial->sigma_turned, 0.01, degrees, "degrees");
  differs("translated", last.inertial->moved, last.inertial->sigma_moved, 0.02, 100, "cm");
  return out;
}
