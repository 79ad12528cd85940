#include "run.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "format.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "progress.hpp"
#include "runner.hpp"

namespace pl = plumbline;

namespace {

struct Images {
  cv::Mat gray, depth;  ///< `depth` is empty where there is none
};

Images read_images(const pl::io::FrameSample& frame, bool with_depth) {
  Images out{pl::opencv::read_gray(frame.image), {}};
  if (with_depth && frame.depth) out.depth = pl::opencv::read_depth(*frame.depth);
  return out;
}

/// A calibration for another resolution would give wrong poses without a word.
void require_calibrated_size(const pl::io::FrameSample& frame, const Images& images,
                             const pl::io::CameraCalibration& camera) {
  pl::opencv::require_resolution(images.gray, camera.width, camera.height, frame.image);
  if (!images.depth.empty()) pl::opencv::require_resolution(images.depth, camera.width, camera.height, *frame.depth);
}

void write_timing(std::ofstream& out, pl::TimeNs t_ns, const FrameOutput& frame) {
  char row[192];
  std::snprintf(row, sizeof row, "%lld,%.4f,%.4f,%.4f,%.4f,", static_cast<long long>(t_ns), 1e3 * frame.timing.track,
                1e3 * frame.timing.estimate, 1e3 * frame.timing.map, 1e3 * frame.timing.total);
  out << row << name_of(frame.health()) << '\n';
}

void write_ply(std::ofstream& out, const std::vector<pl::Vec<double, 3>>& points) {
  out << "ply\nformat ascii 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const pl::Vec<double, 3>& p : points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
}

std::string summary_of(std::size_t read, std::size_t poses, std::size_t skipped, std::size_t refused,
                       std::vector<double> total_ms) {
  std::sort(total_ms.begin(), total_ms.end());
  const double median_ms = total_ms.empty() ? 0 : total_ms[total_ms.size() / 2];
  const double longest_ms = total_ms.empty() ? 0 : total_ms.back();
  return format("%zu frames: %zu poses, %zu skipped, %zu refused; median %.2f ms, longest %.2f ms", read, poses,
                skipped, refused, median_ms, longest_ms);
}

std::unique_ptr<pl::io::OutputFile> open_output(const std::optional<std::filesystem::path>& file) {
  return file ? std::make_unique<pl::io::OutputFile>(*file) : nullptr;
}

}  // namespace

int run_configuration(const RunOptions& options) {
  const Configuration& configuration = configuration_named(options.config);
  pl::io::Recording recording = pl::io::Recording::open(
      options.dataset,
      {.calibration = options.calibration, .start_s = options.start_s, .duration_s = options.duration_s});
  if (configuration.needs.depth && !recording.has_depth())
    throw std::runtime_error(options.dataset.string() + ": " + configuration.name +
                             " needs depth images and the calibration's depth scale");
  if (configuration.needs.imu && !recording.has_imu())
    throw std::runtime_error(options.dataset.string() + ": " + configuration.name +
                             " needs IMU samples, their noise and T_body_camera");

  pl::io::TrajectoryWriter trajectory(options.trajectory);
  const std::unique_ptr<pl::io::OutputFile> timing = open_output(options.timing), ply = open_output(options.landmarks);
  if (timing) timing->stream() << "timestamp_ns,track_ms,estimate_ms,map_ms,total_ms,health\n";

  std::optional<DebugReport> debug;
  if (!options.debug.directory.empty()) {
    debug.emplace(options.debug, options.config + " on " + options.dataset.string(),
                  options.debug.reference
                      ? pl::io::read_trajectory(*options.debug.reference)
                      : recording.read_groundtruth(configuration.needs.imu).value_or(pl::io::Trajectory()));
  }

  const std::unique_ptr<Runner> runner = configuration.make(recording.calibration());
  std::size_t read = 0, skipped = 0, refused = 0, poses = 0;
  std::vector<double> total_ms;
  Progress progress(configuration.name, recording.frame_count());
  pl::io::Recording::Sample sample;
  for (; recording.next(sample); progress.show(read)) {
    if (const pl::ImuSample* imu = std::get_if<pl::ImuSample>(&sample)) {
      if (configuration.needs.imu) runner->add_imu(*imu);
      continue;
    }
    const pl::io::FrameSample& frame = std::get<pl::io::FrameSample>(sample);
    ++read;
    Images images;
    try {
      images = read_images(frame, configuration.needs.depth);
    } catch (const std::runtime_error& damage) {
      ++skipped;
      progress.note(std::string("skipped: ") + damage.what());
      continue;
    }
    if (total_ms.empty()) require_calibrated_size(frame, images, recording.calibration().camera);
    const FrameOutput output = runner->add_frame(frame.t_ns, images.gray, images.depth);
    if (output.refused) {
      ++refused;
      progress.note("refused: " + frame.image.string() + ": " + name_of(*output.refused));
    }
    if (options.all_poses ? output.has_pose() : output.has_sound_pose()) {
      ++poses;
      trajectory.add({frame.t_ns, output.estimate.T_world_body});
    }
    if (timing) write_timing(timing->stream(), frame.t_ns, output);
    if (debug) debug->add(read - 1, frame.t_ns, images.gray, output, runner->inspect());
    total_ms.push_back(1e3 * output.timing.total);
  }
  const std::string summary = summary_of(read, poses, skipped, refused, total_ms);
  if (debug) debug->finish(summary);
  if (poses == 0)
    throw std::runtime_error(options.dataset.string() + ": no pose in " + std::to_string(read) + " frames");

  trajectory.commit();
  if (timing) timing->commit();
  if (ply) {
    write_ply(ply->stream(), runner->landmarks());
    ply->commit();
  }
  std::puts(summary.c_str());
  return 0;
}
