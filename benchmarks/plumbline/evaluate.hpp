#pragma once
/// `plumbline evaluate`: the error of an estimated trajectory, by the definitions of the evo tool.

#include <filesystem>
#include <string>
#include <vector>

struct EvaluateOptions {
  std::filesystem::path reference;
  std::vector<std::filesystem::path> estimates;
  std::filesystem::path to_camera = {};   ///< calibration; the reference is of the body, the estimates of its camera
  std::string align = "se3";              ///< se3, sim3, posyaw, none
  bool json = false;                      ///< instead of a table
  double max_difference_s = 0.02;         ///< between the times of a pair of poses
  double rpe_delta = 1;                   ///< in rpe_unit
  std::string rpe_unit = "s";             ///< s, frames, m
  std::filesystem::path plot = {};        ///< picture of the trajectories to draw, none if empty
  std::filesystem::path error_plot = {};  ///< the same of the error over time
};

/// Prints the figures to stdout; returns the exit status 0. Throws std::runtime_error for files or options that cannot
/// be used.
int run_evaluate(const EvaluateOptions& options);
