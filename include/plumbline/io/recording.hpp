#pragma once
/// A recording on disk, recognized by its layout, as one stream of IMU samples and frames in order of time.
///
///   EuRoC ASL       mav0/cam0/{data.csv, data/, sensor.yaml}, mav0/imu0/{data.csv, sensor.yaml}; TUM-VI:
///   dso/camchain.yaml
///   TUM RGB-D       rgb.txt, depth.txt, imu.csv, calibration.yaml      (all but rgb.txt optional with --calibration)
///   KITTI odometry  image_0/, times.txt, calibration.yaml or calib.txt
///   KITTI raw       image_00/, oxts/, ../calib_cam_to_cam.txt
///   bags            plumbline/io/bag/bag_recording.hpp
///
/// Index files are read and checked whole when the recording is opened; images are only named. Where there is an IMU
/// the frames' times are IMU times: time stamp + camera_time_offset_s. docs/guide/your_recording.md

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/image_scale.hpp"
#include "plumbline/io/imu_calibration_search.hpp"
#include "plumbline/io/recording_layouts.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace plumbline::io {

class Recording {
 public:
  struct Options {
    std::optional<std::filesystem::path> calibration;  ///< instead of the recording's own
    double start_s = 0;                                ///< after the first frame [s]
    double duration_s = std::numeric_limits<double>::infinity();
    std::optional<std::filesystem::path> imu_calibration = {};  ///< noise of the IMU, instead of any other file
    double depth_scale = 0;                                     ///< instead of the calibration's; 0: as it is
    std::optional<double> time_offset_s = {};                   ///< instead of the calibration's
    std::optional<std::filesystem::path> mask = {};             ///< instead of the calibration's
    double image_scale = 0;      ///< of the images when they are read; 0: such that they have no more than max_pixels
    std::size_t max_pixels = 0;  ///< that there is room for; 0: any number
  };
  using Sample = std::variant<ImuSample, FrameSample>;

  /// Throws ReadError.
  static Recording open(const std::filesystem::path& directory, const Options& options);
  static Recording open(const std::filesystem::path& directory) { return open(directory, Options{}); }
  /// Of files that were read already, with the calibration that they state themselves.
  static Recording open(RecordingFiles files, const std::optional<Calibration>& own, const Options& options);

  Layout layout() const { return files_.layout; }
  const RecordingFiles& files() const { return files_; }
  const Calibration& calibration() const { return calibration_; }
  /// What was found while opening, one line each: where calibrations come from, what is not used, what was skipped.
  const std::vector<std::string>& notes() const { return notes_; }
  std::size_t frame_count() const { return files_.frames.size(); }
  const std::vector<FrameSample>& frames() const { return files_.frames; }
  const std::vector<ImuSample>& imu() const { return files_.imu; }
  /// Samples and everything needed to use them: noise and the camera's pose in the body.
  bool has_imu() const { return !files_.imu.empty() && calibration_.imu && calibration_.T_body_camera; }
  bool has_depth() const { return files_.has_depth && calibration_.depth_scale > 0; }

  /// Every file that was read or will be: index files, calibration, truth, images.
  std::vector<std::filesystem::path> inputs() const;

  /// The next item, false after the last frame. Before each frame come all IMU samples up to its time and the first one
  /// at or after it, so that the estimator can interpolate to the image's time; the stream begins with the last IMU
  /// sample at or before the first frame. A frame's time is that in the file plus `time_offset_s`, the estimated
  /// correction of the time offset.
  bool next(Sample& out, double time_offset_s = 0) {
    if (frame_ == frame_count()) return false;
    const TimeNs t = files_.frames[frame_].t_ns + std::llround(1e9 * time_offset_s);
    const bool reached = imu_ > 0 && files_.imu[imu_ - 1].t_ns >= t;
    if (has_imu() && !reached && imu_ < files_.imu.size()) {
      out = files_.imu[imu_++];
    } else {
      out = files_.frames[frame_++];
    }
    return true;
  }
  void rewind() { frame_ = imu_ = 0; }

  /// The file with the true poses of the body, or of the camera where there is no such file.
  std::optional<std::filesystem::path> groundtruth() const {
    return files_.body_truth ? files_.body_truth : files_.camera_truth;
  }
  /// The true trajectory of the body (what a run with an IMU estimates) or of the camera (a run without); the one is
  /// made from the other by T_body_camera where only one is recorded. Empty when the recording has none.
  std::optional<Trajectory> read_groundtruth(bool of_body) const;

 private:
  void read_calibrations(const std::optional<Calibration>& own, const Options& options);
  void scale_images(const Options& options);
  void set_pixel_formats();

  Calibration calibration_;
  RecordingFiles files_;
  std::vector<std::string> notes_;
  std::size_t frame_ = 0, imu_ = 0;  // next of each to be given out
};

/// The camera's calibration is the one asked for, else the recording's own. The noise of the IMU is that of the file
/// asked for, else of the camera's calibration, else of a file beside a calibration asked for, of the recording's own
/// file (EuRoC), or of one beside the recording's own calibration.
inline void Recording::read_calibrations(const std::optional<Calibration>& own, const Options& options) {
  if (options.calibration) files_.calibration = *options.calibration;
  const std::filesystem::path& file = files_.calibration;
  const bool is_own = own && !options.calibration;
  if (!is_own && !std::filesystem::exists(file))
    throw ReadError(file, 0, "no such file: the recording has no calibration of its own, name one");
  calibration_ = is_own ? *own : read_calibration(file);
  if (options.depth_scale > 0) calibration_.depth_scale = options.depth_scale;
  if (options.mask) calibration_.mask = options.mask;
  if (options.time_offset_s) calibration_.camera_time_offset_s = *options.time_offset_s;
  scale_images(options);

  if (options.imu_calibration) {
    files_.imu_calibration = options.imu_calibration;
    detail::read_imu(YamlMap(*files_.imu_calibration), calibration_);
  } else if (!calibration_.imu && !files_.imu.empty()) {
    if (options.calibration || !files_.imu_calibration) {
      const std::vector<std::filesystem::path> beside =
          is_own ? std::vector<std::filesystem::path>() : imu_calibrations_beside(file);
      if (beside.size() == 1) {
        files_.imu_calibration = beside.front();
        notes_.push_back(beside.front().string() + ": the noise of the IMU is taken from this file, beside " +
                         file.filename().string());
      } else if (beside.size() > 1) {
        notes_.push_back(file.string() + ": several files beside it state the noise of an IMU (" +
                         beside[0].filename().string() + ", " + beside[1].filename().string() +
                         (beside.size() > 2 ? ", ..." : "") + "); choose with --imu-calibration");
      }
    }
    if (files_.imu_calibration) detail::read_imu(YamlMap(*files_.imu_calibration), calibration_);
  }
  if (calibration_.imu && files_.held_accel.rate_hz > 0) {
    double& density = calibration_.imu->accel_density;
    const double stated = density;
    density = std::hypot(stated, calibration_.imu_limits.vibration * files_.held_accel.scatter_density);
    notes_.push_back(files_.imu_index->string() + ": accelerometer noise density " + detail::text_of(density) +
                     " instead of " + detail::text_of(stated) + " m/s^2/sqrt(Hz), by the scatter of its true samples");
  }
  notes_.insert(notes_.end(), calibration_.notes.begin(), calibration_.notes.end());
}

/// The camera is that of the scaled images from here on.
inline void Recording::scale_images(const Options& options) {
  CameraCalibration& camera = calibration_.camera;
  const auto size = [&] { return std::to_string(camera.width) + " x " + std::to_string(camera.height); };
  const std::string size_before = size();
  const bool is_asked_for = options.image_scale > 0;
  calibration_.image_scale = is_asked_for ? options.image_scale : fitting_scale(camera, options.max_pixels);
  if (calibration_.image_scale == 1) return;
  scale_camera(calibration_.image_scale, camera);
  notes_.push_back("images of " + size_before + " are scaled to " + size() +
                   (is_asked_for ? ""
                                 : ": there is room for " + std::to_string(options.max_pixels) +
                                       " pixels; --scale chooses another size"));
}

/// How the values of images become brightness and meters: of all frames alike, from some of them.
inline void Recording::set_pixel_formats() {
  constexpr std::size_t looked_at = 8;
  std::vector<FrameSample> some;
  const std::size_t n = std::min(looked_at, frame_count());
  for (std::size_t i = 0; i < n; ++i) some.push_back(files_.frames[i * frame_count() / n]);
  const int bits = used_gray_bits(some);
  if (bits < 16)
    notes_.push_back(files_.frame_index.string() + ": the values of the 16-bit images use " + std::to_string(bits) +
                     " bits only; these are taken");
  for (FrameSample& frame : files_.frames) {
    frame.gray_bits = bits;
    frame.depth_scale = calibration_.depth_scale;
    frame.image_scale = calibration_.image_scale;
  }
}

inline Recording Recording::open(const std::filesystem::path& directory, const Options& options) {
  return open(read_layout(directory), std::nullopt, options);
}

inline Recording Recording::open(RecordingFiles read, const std::optional<Calibration>& own, const Options& options) {
  Recording out;
  out.files_ = std::move(read);
  RecordingFiles& files = out.files_;
  out.notes_ = files.notes;
  out.read_calibrations(own, options);

  if (out.has_imu())  // frames in IMU time
    for (FrameSample& frame : files.frames) frame.t_ns += std::llround(out.calibration_.camera_time_offset_s * 1e9);
  out.set_pixel_formats();
  const TimeNs first = files.frames.front().t_ns, last = files.frames.back().t_ns;
  std::erase_if(files.frames, [&](const FrameSample& frame) {
    const double t = seconds_between(first, frame.t_ns) - options.start_s;
    return !(t >= 0 && t <= options.duration_s);
  });
  if (files.frames.empty())
    throw ReadError(
        files.root, 0,
        "no frame in the part asked for; the recording lasts " + detail::text_of(seconds_between(first, last)) + " s");
  const auto after = std::upper_bound(files.imu.begin(), files.imu.end(), files.frames.front().t_ns,
                                      [](TimeNs t, const ImuSample& sample) { return t < sample.t_ns; });
  if (after != files.imu.begin()) files.imu.erase(files.imu.begin(), after - 1);
  return out;
}

inline std::vector<std::filesystem::path> Recording::inputs() const {
  std::vector<std::filesystem::path> out{files_.frame_index, files_.calibration};
  for (const auto& file : {files_.depth_index, files_.imu_index, files_.accel_index, files_.imu_calibration,
                           files_.body_truth, files_.camera_truth, calibration_.mask})
    if (file) out.push_back(*file);
  if (!files_.bag.empty()) {
    out.insert(out.end(), files_.bag.begin(), files_.bag.end());
    std::erase_if(out, [](const std::filesystem::path& file) { return !std::filesystem::exists(file); });  // topics
    return out;
  }
  for (const FrameSample& frame : files_.frames) {
    out.push_back(frame.image);
    if (frame.depth) out.push_back(*frame.depth);
  }
  return out;
}

inline std::optional<Trajectory> Recording::read_groundtruth(bool of_body) const {
  const std::optional<std::filesystem::path>& wanted = of_body ? files_.body_truth : files_.camera_truth;
  if (wanted) return read_trajectory(*wanted);
  const std::optional<std::filesystem::path>& other = of_body ? files_.camera_truth : files_.body_truth;
  if (!other) return std::nullopt;
  const SE3<double> T_body_camera = calibration_.T_body_camera.value_or(SE3<double>());
  return moved_to(read_trajectory(*other), of_body ? T_body_camera.inverse() : T_body_camera);
}

}  // namespace plumbline::io
