#pragma once
/// The three recording layouts: which files they consist of, and their index files read and checked.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/association.hpp"
#include "plumbline/io/error.hpp"
#include "plumbline/io/text.hpp"

namespace plumbline::io {

enum class Layout { euroc, tum, kitti };

struct FrameSample {
  TimeNs t_ns = 0;
  std::filesystem::path image;
  std::optional<std::filesystem::path> depth;
};

/// Everything a recording's folder holds, the images by name.
struct RecordingFiles {
  Layout layout = Layout::euroc;
  std::vector<FrameSample> frames;
  std::vector<ImuSample> imu;
  bool has_depth = false;
  std::filesystem::path frame_index, calibration;
  std::optional<std::filesystem::path> depth_index, imu_index, imu_calibration, body_truth, camera_truth;
};

namespace detail {

using Path = std::filesystem::path;

inline std::optional<Path> if_exists(const Path& file) {
  return std::filesystem::exists(file) ? std::optional<Path>(file) : std::nullopt;
}

/// Throws unless t lies after the last of the items already read.
template <class Items>
void require_increasing(const RowReader& row, const Items& items, TimeNs t) {
  if (items.empty() || t > items.back().t_ns) return;
  row.fail(t == items.back().t_ns ? "the time stamp is that of the row above"
                                  : "the time stamp is before that of the row above");
}

/// Rows "time, file name", the names relative to `folder`.
inline std::vector<FrameSample> read_image_index(const Path& index, const Path& folder, bool nanoseconds) {
  std::vector<FrameSample> frames;
  for (RowReader row(index); row.next();) {
    row.require_size(2);
    const TimeNs t = nanoseconds ? row.time_in_nanoseconds() : row.time_in_seconds();
    require_increasing(row, frames, t);
    const Path image = folder / Path(std::string(row[1]));
    if (!std::filesystem::exists(image)) row.fail("names the image " + image.string() + ", which does not exist");
    frames.push_back({t, image, std::nullopt});
  }
  if (frames.empty()) throw ReadError(index, 0, "names no images");
  return frames;
}

/// Rows "time, gyroscope x y z [rad/s], accelerometer x y z [m/s^2]".
inline std::vector<ImuSample> read_imu_samples(const Path& file, bool nanoseconds) {
  std::vector<ImuSample> samples;
  for (RowReader row(file); row.next();) {
    row.require_size(7);
    const TimeNs t = nanoseconds ? row.time_in_nanoseconds() : row.time_in_seconds();
    require_increasing(row, samples, t);
    samples.push_back(
        {t, {row.number(1), row.number(2), row.number(3)}, {row.number(4), row.number(5), row.number(6)}});
  }
  if (samples.empty()) throw ReadError(file, 0, "has no IMU samples");
  return samples;
}

/// Gives each frame the depth image nearest in time, at most 20 ms away, each depth used once.
inline void associate_depth(std::vector<FrameSample>& frames, const std::vector<FrameSample>& depths) {
  for (const auto& [i, j] : associate_times(times_of(frames), times_of(depths), 20'000'000))
    frames[i].depth = depths[j].image;
}

inline RecordingFiles read_euroc(const Path& root) {
  const Path mav = root / "mav0";
  RecordingFiles out;
  out.layout = Layout::euroc;
  out.frame_index = mav / "cam0/data.csv";
  out.frames = read_image_index(out.frame_index, mav / "cam0/data", true);
  out.calibration = mav / "cam0/sensor.yaml";
  out.imu_index = if_exists(mav / "imu0/data.csv");
  if (out.imu_index) out.imu = read_imu_samples(*out.imu_index, true);
  out.imu_calibration = if_exists(mav / "imu0/sensor.yaml");
  out.body_truth = if_exists(mav / "state_groundtruth_estimate0/data.csv");
  return out;
}

inline RecordingFiles read_tum(const Path& root) {
  RecordingFiles out;
  out.layout = Layout::tum;
  out.frame_index = root / "rgb.txt";
  out.frames = read_image_index(out.frame_index, root, false);
  out.depth_index = if_exists(root / "depth.txt");
  if (out.depth_index) associate_depth(out.frames, read_image_index(*out.depth_index, root, false));
  out.has_depth = out.depth_index.has_value();
  out.imu_index = if_exists(root / "imu.csv");
  if (out.imu_index) out.imu = read_imu_samples(*out.imu_index, false);
  out.calibration = root / "calibration.yaml";
  out.camera_truth = if_exists(root / "groundtruth.txt");
  out.body_truth = if_exists(root / "groundtruth_body.csv");
  return out;
}

/// times.txt has one time for each image; the images are numbered 000000, 000001, ...
inline RecordingFiles read_kitti(const Path& root) {
  RecordingFiles out;
  out.layout = Layout::kitti;
  out.frame_index = root / "times.txt";
  for (RowReader row(out.frame_index); row.next();) {
    row.require_size(1);
    const TimeNs t = row.time_in_seconds();
    require_increasing(row, out.frames, t);
    const std::string number = std::to_string(out.frames.size());
    const Path stem = root / "image_0" / (std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number);
    std::optional<Path> image;
    for (const char* extension : {".png", ".jpg", ".jpeg"})
      if (!image) image = if_exists(Path(stem).concat(extension));
    if (!image) row.fail("the image " + stem.string() + ".png (or .jpg) does not exist");
    out.frames.push_back({t, *image, std::nullopt});
  }
  if (out.frames.empty()) throw ReadError(out.frame_index, 0, "has no times");
  out.calibration = root / "calibration.yaml";
  out.camera_truth = if_exists(root / "poses.txt");
  return out;
}

}  // namespace detail

/// Recognizes the layout of a folder and reads its index files; throws ReadError.
inline RecordingFiles read_layout(const std::filesystem::path& root) {
  namespace fs = std::filesystem;
  if (!fs::exists(root)) throw ReadError(root, 0, "no such directory");
  if (!fs::is_directory(root)) throw ReadError(root, 0, "not a directory");
  if (fs::is_empty(root)) throw ReadError(root, 0, "the directory is empty");
  if (fs::exists(root / "mav0")) return detail::read_euroc(root);
  if (fs::exists(root / "rgb.txt")) return detail::read_tum(root);
  if (fs::exists(root / "times.txt") || fs::exists(root / "image_0")) return detail::read_kitti(root);
  throw ReadError(root, 0,
                  "not a recording: neither mav0/ (EuRoC) nor rgb.txt (TUM RGB-D) nor times.txt and image_0/ (KITTI)");
}

}  // namespace plumbline::io
