#include "recording_check.hpp"

#include <chrono>
#include <filesystem>

#include "catch.hpp"

namespace io = plumbline::io;

TEST_CASE("recording_check: no findings for good recordings, within a second", "[data]") {
  if (skip_without(PLUMBLINE_TEST_DATA)) return;
  int recordings = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PLUMBLINE_TEST_DATA)) {
    const std::filesystem::path& folder = entry.path();
    if (!exists(folder / "mav0/cam0") && !exists(folder / "rgb.txt") && !exists(folder / "times.txt")) continue;
    const io::Recording recording = io::Recording::open(folder);
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<Finding> findings = check_recording(recording, {recording.has_depth(), recording.has_imu()});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    CAPTURE(folder, took.count());
    for (const Finding& finding : findings) UNSCOPED_INFO(finding.text);
    CHECK(findings.empty());
    CHECK(took.count() < 1);
    ++recordings;
  }
  REQUIRE(recordings > 0);
}
