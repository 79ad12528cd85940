#pragma once
/// The files that `plumbline run` writes. They appear when the run is over: all of them or none.

#include <filesystem>
#include <optional>
#include <vector>

#include "inspection.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/trajectory.hpp"
#include "runner.hpp"

struct RunPaths {
  std::filesystem::path trajectory;
  std::optional<std::filesystem::path> timing, states, landmarks;
};

class RunFiles {
 public:
  /// Throws std::runtime_error where a file cannot be written, or would overwrite another one or one of the inputs.
  RunFiles(const RunPaths& paths, const std::vector<std::filesystem::path>& inputs);

  void add_pose(plumbline::TimeNs t_ns, const FrameOutput& output) {
    trajectory_.add({t_ns, output.estimate.T_world_body});
  }
  void add_timing(plumbline::TimeNs t_ns, const FrameOutput& output);
  /// `inspection` was made after the frame.
  void add_state(plumbline::TimeNs t_ns, const FrameOutput& output, const Inspection& inspection);
  void add_landmarks(const std::vector<plumbline::Vec<double, 3>>& points);

  bool has_states() const { return states_.has_value(); }
  bool has_landmarks() const { return landmarks_.has_value(); }

  /// After a run without a pose: the tables of the frames.
  void commit_tables();
  void commit_all();

 private:
  plumbline::io::TrajectoryWriter trajectory_;
  std::optional<plumbline::io::OutputFile> timing_, states_, landmarks_;
};
