#include "recording_check.hpp"

#include <iterator>

std::vector<Finding> check_recording(const plumbline::io::Recording& recording, const Needs& needs) {
  std::vector<Finding> findings = check_time_offsets(recording, needs);
  const auto append = [&](std::vector<Finding> more) {
    findings.insert(findings.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  };
  if (needs.imu) append(check_imu_samples(recording));
  append(check_images(recording, needs));
  return findings;
}
