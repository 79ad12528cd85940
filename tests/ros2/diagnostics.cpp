#include "plumbline_ros2/diagnostics.hpp"

#include <algorithm>
#include <string>

#include "catch.hpp"
#include "message_like.hpp"

using namespace plumbline;
using namespace plumbline::ros2;

namespace {

Status status(HealthState state, HealthReason reason) {
  Status out;
  out.health = {state, reason};
  return out;
}
std::string value_of(const message_like::DiagnosticStatus& message, const std::string& key) {
  const auto found =
      std::find_if(message.values.begin(), message.values.end(), [&](const auto& entry) { return entry.key == key; });
  return found == message.values.end() ? "none" : found->value;
}

}  // namespace

TEST_CASE("level and text follow the health") {
  message_like::DiagnosticStatus message;
  set_diagnostics(status(HealthState::tracking, HealthReason::none), message);
  REQUIRE(message.level == 0);
  REQUIRE(message.message == "tracking");
  set_diagnostics(status(HealthState::degraded, HealthReason::scale_uncertain), message);
  REQUIRE(message.level == 1);
  REQUIRE(message.message == "degraded: scale uncertain");
  set_diagnostics(status(HealthState::initializing, HealthReason::aligning), message);
  REQUIRE(message.level == 1);
  set_diagnostics(status(HealthState::lost, HealthReason::few_features), message);
  REQUIRE(message.level == 2);
  Status silent = status(HealthState::tracking, HealthReason::none);
  silent.silent_s = 3.25;
  set_diagnostics(silent, message);
  REQUIRE(message.level == 2);
  REQUIRE(message.message == "no frame for 3.2 s");
}

TEST_CASE("all counts are among the values") {
  Status counted;
  counted.counts = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  message_like::DiagnosticStatus message;
  set_diagnostics(counted, message);
  const char* const keys[] = {"frames",
                              "poses",
                              "frames dropped",
                              "images without depth",
                              "images skipped",
                              "frames refused",
                              "IMU samples refused",
                              "messages before calibration",
                              "messages unreadable"};
  for (std::size_t i = 0; i < 9; ++i) REQUIRE(value_of(message, keys[i]) == std::to_string(i + 1));
}
