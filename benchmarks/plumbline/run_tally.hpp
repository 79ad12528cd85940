#pragma once
/// What became of the frames of a run: the counts, and where there was no pose, the reason that stood longest.

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "plumbline/io/calibration_data.hpp"
#include "runner.hpp"

class RunTally {
 public:
  /// An image that could not be read.
  void skip() { ++read_, ++skipped_; }
  void add(const FrameOutput& output, bool is_in_trajectory);

  std::size_t read() const { return read_; }
  std::size_t poses() const { return poses_; }
  bool is_first() const { return total_ms_.empty(); }  ///< no frame has been added yet

  /// Frames by health, resets, times: one line.
  std::string summary() const;
  /// Where the time of the frames with a sound pose went, stage by stage: a table.
  std::string times() const;
  /// Whether more than half of the frames gave no sound pose.
  bool is_mostly_without() const { return 2 * (without_ + skipped_) > read_; }
  /// How many frames gave no sound pose, and the reason that stood longest, with its figures.
  std::string why_no_pose() const;
  /// Whether there are poses, and none of them in the state `tracking`.
  bool is_never_tracking() const;
  /// The state and reason that most frames with a sound pose were in.
  std::string why_never_tracking() const;

 private:
  struct Reason {
    std::size_t frames = 0;
    std::string figures;  ///< of the latest frame
  };

  std::size_t read_ = 0, skipped_ = 0, refused_ = 0, poses_ = 0, without_ = 0;
  std::array<std::size_t, 4> by_health_{};  // in the order of HealthState
  std::uint32_t resets_ = 0;
  std::vector<double> total_ms_;
  std::vector<plumbline::FrameTiming> sound_;         // of the frames with a sound pose
  std::vector<MapTiming> map_;                        // of the same
  std::map<std::string, Reason> reasons_;             // of frames without a sound pose
  std::map<std::string, std::size_t> sound_reasons_;  // of frames with one: how many
};

/// What the estimator found to be wrong with the calibration of a rig with an IMU, line by line.
std::string found_wrong(const plumbline::io::Calibration& calibration, const Inspection& last);
