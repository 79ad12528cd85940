#pragma once
/// What the folder of a recording holds, images by name.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/frame_sample.hpp"
#include "plumbline/io/held_samples.hpp"

namespace plumbline::io {

enum class Layout { euroc, tum, kitti, kitti_raw, bag };

/// Everything a recording's folder holds, the images by name.
struct RecordingFiles {
  Layout layout = Layout::euroc;
  std::filesystem::path root;
  std::vector<FrameSample> frames;
  std::vector<ImuSample> imu;
  HeldSensor held_accel;  ///< an accelerometer slower than the samples, interpolated
  bool has_depth = false;
  std::filesystem::path frame_index, calibration;
  std::optional<std::filesystem::path> depth_index, imu_index, imu_calibration, body_truth, camera_truth;
  std::optional<std::filesystem::path> accel_index;  ///< where the accelerometer has a file of its own
  std::vector<std::filesystem::path> bag;            ///< the files of a bag; names above are then of topics in it
  std::vector<std::filesystem::path> other_sensors;  ///< cameras that are there beside the one that is read
  std::vector<std::string> notes;                    ///< what is said of the files, one line each
};

}  // namespace plumbline::io
