#pragma once
/// diagnostic_msgs/DiagnosticStatus from the health of the latest frame and the counts of what was not used.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>

#include "plumbline/initialization/init_report.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline::ros2 {

/// Frames and IMU samples since the node began.
struct Counts {
  std::size_t frames = 0, poses = 0;         ///< given to the estimator; published
  std::size_t dropped = 0;                   ///< frames, because the estimator is too slow
  std::size_t without_depth = 0;             ///< images, because no depth image fits
  std::size_t skipped = 0;                   ///< images that cannot be read, or have another size than the calibration
  std::size_t refused = 0, refused_imu = 0;  ///< by the estimator
  std::size_t before_calibration = 0;        ///< messages before camera_info
  std::size_t unreadable = 0;                ///< messages with an impossible time stamp or value
};

struct Status {
  Counts counts;
  Health health;
  InitStage stage = InitStage::few_features;
  int tracked = 0;
  std::uint32_t resets = 0;
  int loops = 0;
  std::size_t waiting = 0;  ///< frames
  double total_ms = 0, time_offset_s = 0;
  double silent_s = 0;  ///< since the latest frame came
};

/// In the order of DiagnosticStatus.
enum class Level : std::uint8_t { ok = 0, warn = 1, error = 2 };

constexpr double longest_silence_s = 2;

inline Level level_of(const Status& status) {
  if (status.silent_s > longest_silence_s || status.health.state == HealthState::lost) return Level::error;
  return status.health.state == HealthState::tracking ? Level::ok : Level::warn;
}

/// "degraded: scale uncertain".
inline std::string text_of(const Status& status) {
  char text[64];
  std::snprintf(text, sizeof text, "no frame for %.1f s", status.silent_s);
  if (status.silent_s > longest_silence_s) return text;
  std::string out = name_of(status.health.state);
  if (status.health.reason != HealthReason::none) out += std::string(": ") + name_of(status.health.reason);
  return out;
}

/// Sets level, message and values; `message.values` has KeyValue as its element.
template <class Message>
void set_diagnostics(const Status& status, Message& message) {
  message.level = static_cast<decltype(message.level)>(level_of(status));
  message.message = text_of(status);
  message.values.clear();
  const auto add_text = [&](const char* key, std::string value) {
    auto& entry = message.values.emplace_back();
    entry.key = key;
    entry.value = std::move(value);
  };
  const auto add = [&](const char* key, auto number) { add_text(key, std::to_string(number)); };
  add_text("health", name_of(status.health.state));
  add_text("reason", name_of(status.health.reason));
  add_text("initialization", name_of(status.stage));
  add("tracked", status.tracked);
  add("resets", status.resets);
  add("loops", status.loops);
  add("frames", status.counts.frames);
  add("poses", status.counts.poses);
  add("frames waiting", status.waiting);
  add("frames dropped", status.counts.dropped);
  add("images without depth", status.counts.without_depth);
  add("images skipped", status.counts.skipped);
  add("frames refused", status.counts.refused);
  add("IMU samples refused", status.counts.refused_imu);
  add("messages before calibration", status.counts.before_calibration);
  add("messages unreadable", status.counts.unreadable);
  add("time of a frame [ms]", status.total_ms);
  add("time offset [s]", status.time_offset_s);
}

}  // namespace plumbline::ros2
