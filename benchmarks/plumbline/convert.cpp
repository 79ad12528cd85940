#include "convert.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "format.hpp"
#include "interrupt.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/printable.hpp"
#include "progress.hpp"

#ifdef PLUMBLINE_HAS_BAG
#include "plumbline/io/bag/bag_recording.hpp"

namespace {

namespace fs = std::filesystem;
namespace io = plumbline::io;
namespace pl = plumbline;

std::string text_in_seconds(pl::TimeNs t_ns) {
  return format("%lld.%09lld", static_cast<long long>(t_ns / 1'000'000'000),
                static_cast<long long>(t_ns % 1'000'000'000));
}

void write_file(const fs::path& file, const std::string& text) {
  io::OutputFile out(file);
  out.stream() << text;
  out.commit();
}

/// As it was sent, else as PNG; returns the name with its extension.
std::string write_image_as_sent(const fs::path& folder, pl::TimeNs t_ns, const io::bag::EncodedImage& image) {
  const bool is_jpeg = image.bytes.size() > 2 && image.bytes[0] == 0xFF && image.bytes[1] == 0xD8;
  const std::string name = std::to_string(t_ns) + (is_jpeg ? ".jpg" : ".png");
  const fs::path file = folder / name;
  if (image.bytes.empty()) {
    if (!cv::imwrite(file.string(), image.pixels)) throw std::runtime_error(file.string() + ": cannot be written");
    return name;
  }
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(image.bytes.data()), static_cast<std::streamsize>(image.bytes.size()));
  if (!stream.flush()) throw std::runtime_error(file.string() + ": cannot be written (disk full?)");
  return name;
}

std::string text_of(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) out += format("%s%.17g", out.empty() ? "" : ", ", value);
  return "[" + out + "]";
}

/// plumbline's own format, whatever the calibration came from.
std::string calibration_yaml(const io::Calibration& calibration) {
  const io::CameraCalibration& camera = calibration.camera;
  std::string out = "camera:\n  model: " + camera.model + "\n  intrinsics: " + text_of(camera.intrinsics) +
                    "\n  distortion: " + camera.distortion + "\n";
  if (!camera.distortion_coefficients.empty())
    out += "  distortion_coefficients: " + text_of(camera.distortion_coefficients) + "\n";
  out += format("  resolution: [%d, %d]\n", camera.width, camera.height);
  if (camera.rate_hz > 0) out += format("  rate_hz: %.17g\n", camera.rate_hz);
  if (calibration.camera_time_offset_s != 0)
    out += format("  time_offset_s: %.17g\n", calibration.camera_time_offset_s);
  if (camera.readout_s) out += format("  readout_s: %.17g\n", *camera.readout_s);
  if (calibration.depth_scale > 0) out += format("depth:\n  scale: %.17g\n", calibration.depth_scale);
  if (!calibration.T_body_camera) return out;
  const pl::Mat<double, 3, 3> R = calibration.T_body_camera->R();
  out += "T_body_camera:\n  [";
  for (int i = 0; i < 3; ++i)
    out += format("%.17g, %.17g, %.17g, %.17g,\n   ", R(i, 0), R(i, 1), R(i, 2), calibration.T_body_camera->p()[i]);
  out += "0, 0, 0, 1]\n";
  if (!calibration.imu) return out;
  const pl::ImuNoise& noise = *calibration.imu;
  out += format(
      "imu:\n  rate_hz: %.17g\n  gyroscope_noise_density: %.17g\n  gyroscope_random_walk: %.17g\n"
      "  accelerometer_noise_density: %.17g\n  accelerometer_random_walk: %.17g\n",
      noise.rate_hz, noise.gyro_density, noise.gyro_walk, noise.accel_density, noise.accel_walk);
  return out + format("  gyroscope_full_scale: %.17g\n  accelerometer_full_scale: %.17g\n",
                      calibration.imu_limits.gyro_full_scale, calibration.imu_limits.accel_full_scale);
}

std::string imu_rows(const std::vector<pl::ImuSample>& samples, bool is_euroc) {
  std::string out =
      is_euroc ? "#timestamp [ns],wx,wy,wz [rad s^-1],ax,ay,az [m s^-2]\n" : "#timestamp [s] wx wy wz ax ay az\n";
  const char separator = is_euroc ? ',' : ' ';
  for (const pl::ImuSample& sample : samples) {
    out += is_euroc ? std::to_string(sample.t_ns) : text_in_seconds(sample.t_ns);
    for (const pl::Vec<double, 3>& x : {sample.gyro, sample.accel})
      for (int i = 0; i < 3; ++i) out += format("%c%.17g", separator, x[i]);
    out += "\n";
  }
  return out;
}

/// The folders and files of a layout, relative to the recording.
struct FolderLayout {
  fs::path images, image_index, imu;
  std::string prefix;  // of the names in the index
  bool is_euroc;
};

FolderLayout layout_named(const std::string& name) {
  if (name == "euroc") return {"mav0/cam0/data", "mav0/cam0/data.csv", "mav0/imu0/data.csv", "", true};
  return {"rgb", "rgb.txt", "imu.csv", "rgb/", false};
}

void copy_truth(const io::RecordingFiles& files, const fs::path& out, bool is_euroc) {
  if (files.body_truth) {
    const fs::path to = out / (is_euroc ? "mav0/state_groundtruth_estimate0/data.csv" : "groundtruth_body.csv");
    fs::create_directories(to.parent_path());
    fs::copy_file(*files.body_truth, to);
  }
  if (files.camera_truth && !is_euroc) fs::copy_file(*files.camera_truth, out / "groundtruth.txt");
}

}  // namespace

int run_convert(const ConvertOptions& options) {
  if (!io::bag::is_bag(options.bag)) throw std::runtime_error(options.bag.string() + ": no such bag");
  const TopicOptions& topics = options.topics;
  const io::Recording recording =
      io::bag::open_recording(options.bag, {topics.image, topics.depth, topics.imu, topics.camera_info},
                              {.calibration = options.calibration,
                               .start_s = options.start_s,
                               .duration_s = options.duration_s,
                               .imu_calibration = options.imu_calibration});
  for (const std::string& note : recording.notes())
    std::fprintf(stderr, "plumbline: note: %s\n", io::printable(note).c_str());
  const io::RecordingFiles& files = recording.files();
  const std::string name = options.layout.empty() ? (files.has_depth ? "tum" : "euroc") : options.layout;
  if (name == "euroc" && files.has_depth)
    throw std::runtime_error(
        "--layout euroc: it has no place for depth images; leave them out with --depth-topic none");
  const FolderLayout layout = layout_named(name);
  const fs::path& out = options.out;
  if (fs::exists(out) && !(fs::is_directory(out) && fs::is_empty(out)))
    throw std::runtime_error(out.string() + ": exists and is not an empty folder");
  std::error_code error;
  fs::create_directories(out / layout.images, error);
  if (files.has_depth) fs::create_directories(out / "depth", error);
  if (error) throw std::runtime_error(out.string() + ": cannot be made: " + error.message());

  const Interruptible interruptible;
  const auto source = std::dynamic_pointer_cast<io::bag::BagImages>(recording.frames().front().source);
  const pl::TimeNs shift_ns =
      recording.has_imu() ? std::llround(1e9 * recording.calibration().camera_time_offset_s) : pl::TimeNs(0);
  const auto stamp = [&](pl::TimeNs t_ns) {
    return layout.is_euroc ? std::to_string(t_ns) + "," : text_in_seconds(t_ns) + " ";
  };
  std::string index = layout.is_euroc ? "#timestamp [ns],filename\n" : "# timestamp filename\n", depth_index = index;
  Progress progress("convert", recording.frame_count());
  std::size_t written = 0, skipped = 0;
  for (const io::FrameSample& frame : recording.frames()) {
    if (Interruptible::is_asked_to_stop()) throw Interrupted("interrupted; " + out.string() + " is incomplete");
    const pl::TimeNs t_ns = frame.t_ns - shift_ns;
    try {
      const std::string image = write_image_as_sent(out / layout.images, t_ns, source->encoded(frame.image_number));
      index += stamp(t_ns) + layout.prefix + image + "\n";
      if (frame.depth) {
        const std::string depth = write_image_as_sent(out / "depth", t_ns, {{}, io::read_depth(frame)});
        depth_index += stamp(t_ns) + "depth/" + depth + "\n";
      }
    } catch (const std::runtime_error& damage) {
      ++skipped;
      progress.note(std::string("skipped: ") + damage.what());
    }
    progress.show(++written);
  }
  if (!recording.imu().empty()) {
    fs::create_directories((out / layout.imu).parent_path());
    write_file(out / layout.imu, imu_rows(recording.imu(), layout.is_euroc));
  }
  if (files.has_depth) write_file(out / "depth.txt", depth_index);
  write_file(out / "calibration.yaml", calibration_yaml(recording.calibration()));
  copy_truth(files, out, layout.is_euroc);
  write_file(out / layout.image_index, index);  // last: what makes the folder a recording
  std::printf("%s: %zu frames%s, %zu IMU samples, layout %s\n", io::printable(out.string()).c_str(), written - skipped,
              files.has_depth ? " with depth" : "", recording.imu().size(), name.c_str());
  if (!recording.imu().empty() && !recording.has_imu())
    std::printf("an IMU is used with its noise and T_body_camera, which a bag does not state: add both to %s\n",
                io::printable((out / "calibration.yaml").string()).c_str());
  return 0;
}

#else

int run_convert(const ConvertOptions& options) {
  open_recording(options.bag);
  throw std::runtime_error(options.bag.string() + ": no bag");
}

#endif
