#pragma once
/// A picture of two trajectories from above.

#include <filesystem>
#include <string>

#include "plumbline/io/trajectory.hpp"

/// Draws the reference and the estimate, which is already aligned to it, seen along the axis of the smallest extent, in
/// equal scale, with a grid in metres. Without a reference, an empty one, the estimate alone. Only the part of the
/// reference the estimate's times cover is drawn strongly. Throws std::runtime_error when the file cannot be written.
void draw_trajectories(const std::filesystem::path& png, const plumbline::io::Trajectory& reference,
                       const plumbline::io::Trajectory& estimate, const std::string& title);
