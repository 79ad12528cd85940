#pragma once
/// Pictures of trajectories from above, and of their errors over time.

#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/io/trajectory.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"

struct NamedTrajectory {
  std::string name;
  plumbline::io::Trajectory poses;
};

/// Throws std::runtime_error unless the name ends with .png or .jpg.
void require_picture_name(const std::filesystem::path& file);

/// Draws the reference and the estimates, which are already aligned to it, seen along the axis of the smallest extent,
/// in equal scale, with a grid in meters. Without a reference, an empty one, the estimates alone. Only the part of the
/// reference the estimates' times cover is drawn strongly. Throws std::runtime_error when the file cannot be written.
void draw_trajectories(const std::filesystem::path& file, const plumbline::io::Trajectory& reference,
                       const std::vector<NamedTrajectory>& estimates, const std::string& title);
void draw_trajectories(const std::filesystem::path& file, const plumbline::io::Trajectory& reference,
                       const plumbline::io::Trajectory& estimate, const std::string& title);

struct ErrorCurve {
  std::string name;
  std::vector<plumbline::io::StampedError> errors;
};

/// Draws the distance to the truth over the time since the first pose.
void draw_errors(const std::filesystem::path& file, const std::vector<ErrorCurve>& curves, const std::string& title);
