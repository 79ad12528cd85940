#pragma once
/// `plumbline simulate`: a recording of a simulated room with exact truth, in a layout that `plumbline run` reads.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "simulate_faults.hpp"

struct SimulateOptions {
  std::string scene = "room";         ///< one of scene_names()
  std::filesystem::path out;          ///< folder to create; must not exist or be empty
  std::uint64_t seed = 1;             ///< of the surfaces, the motion and the noise
  double duration_s = 20;             ///< [s]; 20 frames each second
  int laps = 0;                       ///< the recording ends when so many laps are complete; 0: after duration_s
  std::vector<double> stop_s;         ///< begin and end of a stop on the way [s]; empty: none
  double late_s = 0;                  ///< stamps of the images come after the images [s]
  double readout_s = 0;               ///< the shutter rolls: between the first and the last row of an image [s]
  double drop = 0;                    ///< part of the images that is missing
  std::vector<int> size;              ///< width and height of the images [px]; empty: those of the layout
  std::string imu = "default";        ///< one of imu_names(): the quality of the sensor
  std::filesystem::path real_imu;     ///< EuRoC recording whose true path and IMU samples are used; empty: none
  std::filesystem::path calibration;  ///< of the camera of `real_imu`; empty: that of the recording
  double start_s = 0;                 ///< begin in `real_imu`, after its first true state [s]
  std::string layout = "tum";         ///< one of layout_names(): tum (RGB-D) or euroc (one distorted gray camera)
  SimulateFaults faults;
};

std::vector<std::string> scene_names();
std::vector<std::string> imu_names();
std::vector<std::string> layout_names();

/// Writes the recording and shows its progress on stderr; returns the exit status 0. Throws std::runtime_error that
/// has a message of one line.
int run_simulate(const SimulateOptions& options);
