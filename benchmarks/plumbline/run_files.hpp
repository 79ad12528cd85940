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
  std::optional<std::filesystem::path> trajectory, timing, states, landmarks, loops, map;
  std::optional<std::filesystem::path> world, final;  ///< trajectories beside that in the map
};

class RunFiles {
 public:
  /// Throws std::runtime_error where a file cannot be written, or would overwrite another one or one of the inputs.
  RunFiles(const RunPaths& paths, const std::vector<std::filesystem::path>& inputs);

  void add_pose(plumbline::TimeNs t_ns, const FrameOutput& output) {
    if (trajectory_ && output.is_in_map) trajectory_->add({t_ns, output.T_map_body()});
    if (world_) world_->add({t_ns, output.estimate.T_world_body});
    if (final_) poses_.push_back({t_ns, output.estimate.T_world_body});
  }
  /// The poses of the run as the map corrects them at its end.
  void add_final(const std::vector<MapCorrection>& corrections);
  void add_timing(plumbline::TimeNs t_ns, const FrameOutput& output);
  /// `inspection` was made after the frame.
  void add_state(plumbline::TimeNs t_ns, const FrameOutput& output, const Inspection& inspection);
  void add_map(const std::vector<std::byte>& bytes);
  void add_loops(const std::vector<MapLoop>& loops);
  void add_landmarks(const std::vector<plumbline::Vec<double, 3>>& points);

  bool has_states() const { return states_.has_value(); }
  bool has_map() const { return map_.has_value(); }
  bool has_landmarks() const { return landmarks_.has_value(); }

  /// After a run without a pose: the tables of the frames.
  void commit_tables();
  void commit_all();

 private:
  std::optional<plumbline::io::TrajectoryWriter> trajectory_, world_, final_;
  plumbline::io::Trajectory poses_;  ///< in the world
  std::optional<plumbline::io::OutputFile> timing_, states_, landmarks_, loops_, map_;
};
