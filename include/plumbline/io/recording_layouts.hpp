#pragma once
/// The recording layouts: which files they consist of, and their index files read and checked.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/io/association.hpp"
#include "plumbline/io/error.hpp"
#include "plumbline/io/imu_samples.hpp"
#include "plumbline/io/index_rows.hpp"
#include "plumbline/io/kitti_layouts.hpp"
#include "plumbline/io/recording_files.hpp"
#include "plumbline/io/skipped_rows.hpp"
#include "plumbline/io/text.hpp"

namespace plumbline::io {

namespace detail {

/// Rows "time, file name", the names relative to `folder`. Images that do not exist are skipped.
inline std::vector<FrameSample> read_image_index(const Path& index, const Path& folder, TimeUnit expected,
                                                 std::vector<std::string>& notes) {
  std::vector<FrameSample> frames;
  SkippedRows skipped;
  const TimeUnit unit = unit_of(index, expected, notes);
  std::size_t rows = 0;
  bool is_said = false;
  for (RowReader row(index); row.next();) {
    ++rows;
    if (!has_columns(row, 2, index, skipped, notes, is_said)) continue;
    const TimeNs t = row.time_in(unit);
    if (!is_after(row, frames, t, skipped)) continue;
    const Path image = folder / Path(std::string(row[1]));
    if (!std::filesystem::exists(image)) {
      skipped.add(row, "the image does not exist", ": " + image.string());
      continue;
    }
    frames.push_back({.t_ns = t, .image = image, .depth = {}, .source = {}});
  }
  skipped.report(index, rows, notes);
  if (frames.empty()) throw ReadError(index, 0, "names no images");
  return frames;
}

/// Gives each frame the depth image nearest in time, at most 20 ms away, each depth used once.
inline void associate_depth(std::vector<FrameSample>& frames, const std::vector<FrameSample>& depths) {
  for (const auto& [i, j] : associate_times(times_of(frames), times_of(depths), 20'000'000))
    frames[i].depth = depths[j].image, frames[i].depth_number = depths[j].image_number;
}

/// The names that a sensor's own file has.
inline std::vector<Path> sensor_files(const Path& root, const std::string& name, const std::string& full_name) {
  std::vector<Path> out;
  for (const std::string& stem : {name, full_name, "d400_" + full_name})
    for (const char* extension : {".csv", ".txt"}) out.push_back(root / (stem + extension));
  return out;
}

/// The one file of the IMU, or those of its two sensors; nothing where there is neither.
inline void read_imu_files(RecordingFiles& out, const Path& together, const std::vector<Path>& gyro,
                           const std::vector<Path>& accel, TimeUnit expected) {
  out.imu_index = if_exists(together);
  if (out.imu_index) {
    out.imu = read_imu_samples(*out.imu_index, expected, out.notes);
    out.held_accel = note_held(*out.imu_index, out.imu, out.notes);
    return;
  }
  const std::optional<Path> g = if_exists(first_existing(gyro)), a = if_exists(first_existing(accel));
  if (g && a) {
    out.imu_index = g;
    out.accel_index = a;
    out.imu = read_separate_sensors(*g, *a, expected, out.notes, out.held_accel);
  } else if (g || a) {
    out.notes.push_back((g ? *g : *a).string() + " is not used: there is no file of the " +
                        (g ? "accelerometer" : "gyroscope") + " beside it");
  }
}

inline RecordingFiles read_euroc(const Path& root) {
  const Path mav = root / "mav0";
  RecordingFiles out;
  out.layout = Layout::euroc;
  out.frame_index = mav / "cam0/data.csv";
  out.frames = read_image_index(out.frame_index, mav / "cam0/data", TimeUnit::nanoseconds, out.notes);
  out.calibration = first_existing(
      {mav / "cam0/sensor.yaml", root / "dso/camchain.yaml", root / "camchain.yaml", root / "calibration.yaml"});
  read_imu_files(out, mav / "imu0/data.csv", {mav / "gyro0/data.csv"}, {mav / "accel0/data.csv"},
                 TimeUnit::nanoseconds);
  out.imu_calibration = if_exists(mav / "imu0/sensor.yaml");
  for (const char* name : {"state_groundtruth_estimate0", "mocap0"})  // EuRoC, TUM-VI
    if (!out.body_truth) out.body_truth = if_exists(mav / name / "data.csv");
  if (const auto camera = if_exists(mav / "cam1/data.csv")) out.other_sensors.push_back(*camera);
  return out;
}

inline RecordingFiles read_tum(const Path& root) {
  RecordingFiles out;
  out.layout = Layout::tum;
  out.frame_index = root / "rgb.txt";
  out.frames = read_image_index(out.frame_index, root, TimeUnit::seconds, out.notes);
  out.depth_index = if_exists(root / "depth.txt");
  if (out.depth_index)
    associate_depth(out.frames, read_image_index(*out.depth_index, root, TimeUnit::seconds, out.notes));
  out.has_depth = out.depth_index.has_value();
  read_imu_files(out, root / "imu.csv", sensor_files(root, "gyro", "gyroscope"),
                 sensor_files(root, "accel", "accelerometer"), TimeUnit::seconds);
  out.calibration = first_existing({root / "calibration.yaml", root / "camchain.yaml"});
  out.camera_truth = if_exists(root / "groundtruth.txt");
  out.body_truth = if_exists(root / "groundtruth_body.csv");
  return out;
}

}  // namespace detail

/// Recognizes the layout of a folder and reads its index files; throws ReadError.
inline RecordingFiles read_layout(const std::filesystem::path& root) {
  namespace fs = std::filesystem;
  if (!fs::exists(root)) throw ReadError(root, 0, "no such directory");
  if (!fs::is_directory(root)) throw ReadError(root, 0, "not a directory");
  if (fs::is_empty(root)) throw ReadError(root, 0, "the directory is empty");
  RecordingFiles out;
  if (fs::exists(root / "mav0"))
    out = detail::read_euroc(root);
  else if (fs::exists(root / "rgb.txt"))
    out = detail::read_tum(root);
  else if (fs::exists(root / "image_00"))
    out = detail::read_kitti_raw_layout(root);
  else if (fs::exists(root / "times.txt") || fs::exists(root / "image_0"))
    out = detail::read_kitti(root);
  else
    throw ReadError(
        root, 0,
        "not a recording: neither mav0/ (EuRoC) nor rgb.txt (TUM RGB-D) nor times.txt and image_0/ (KITTI odometry) "
        "nor image_00/ (KITTI raw)");
  out.root = root;
  return out;
}

}  // namespace plumbline::io
