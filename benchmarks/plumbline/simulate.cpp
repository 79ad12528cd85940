#include "simulate.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <variant>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "format.hpp"
#include "misuse.hpp"
#include "nearest.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/output_file.hpp"
#include "plumbline/io/text.hpp"
#include "plumbline/testing/frame_drops.hpp"
#include "plumbline/testing/recorded_path.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/simulated_imu.hpp"
#include "progress.hpp"

namespace fs = std::filesystem;
using namespace plumbline;
using namespace plumbline::testing;

namespace {

constexpr TimeNs t_start_ns = 1'600'000'000'000'000'000;
constexpr int camera_rate_hz = 20, imu_rate_hz = 200;  // frames are taken at the times of IMU samples
constexpr int imu_per_frame = imu_rate_hz / camera_rate_hz;
constexpr int longest_drop = 7;  // [frames], which leaves 0.4 s between two images

struct ImuSet {
  const char* name;
  ImuQuality quality;
};
const std::array imu_sets = {
    ImuSet{"default", {}},  // as the sensor of the EuRoC recordings
    ImuSet{"none", ImuQuality::perfect(imu_rate_hz)},
    ImuSet{"low-cost", {{1.0e-3, 1.0e-2, 1.0e-4, 5.0e-3, imu_rate_hz}, 0.05, 0.2}},     // consumer MEMS
    ImuSet{"tactical", {{3.5e-5, 2.5e-4, 1.0e-6, 2.0e-5, imu_rate_hz}, 0.001, 0.01}}};  // temperature compensated MEMS

/// A camera and the size of its images [px].
template <class Model>
struct Imager {
  Model camera;
  int width, height;

  /// The same field of view across, other pixels. An empty size changes nothing.
  Imager resized(const std::vector<int>& size) const {
    if (size.empty()) return *this;
    Imager out{camera, size[0], size[1]};
    const double sx = double(size[0]) / width, sy = double(size[1]) / height;
    out.camera.fx *= sx;
    out.camera.fy *= sx;
    out.camera.cx = (camera.cx + 0.5) * sx - 0.5;
    out.camera.cy = (camera.cy + 0.5) * sy - 0.5;
    return out;
  }
};
const Imager<Pinhole<double>> rgbd_imager{{536.2, 535.8, 321.4, 245.7}, 640, 480};
const Imager<Pinhole<double, RadTan>> mono_imager{
    {458.6, 457.4, 367.1, 248.2, {-0.2834, 0.07396, 1.94e-4, 1.76e-5}}, 752, 480};

std::string seconds(TimeNs t_ns) {
  return format("%lld.%09lld", static_cast<long long>(t_ns / 1'000'000'000),
                static_cast<long long>(t_ns % 1'000'000'000));
}
std::string image_name(TimeNs t_ns) { return std::to_string(t_ns) + ".png"; }

void write_text(const fs::path& file, const std::string& text) {
  io::OutputFile out(file);
  out.stream() << text;
  out.commit();
}

void write_image(const fs::path& file,
                 const cv::Mat& image) {  // Huffman only: a third faster, and smaller on noisy images
  if (!cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY})) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

cv::Mat gray_mat(SimulatedCamera::Frame& frame) {
  const ImageView<std::uint8_t> view = frame.gray.view();
  return {view.height, view.width, CV_8U, view.data};
}
cv::Mat depth_mat(SimulatedCamera::Frame& frame) {
  const ImageView<std::uint16_t> view = frame.depth.view();
  return {view.height, view.width, CV_16U, view.data};
}

/// The lower part of an image shows the vehicle: a texture that stays where it is, near the camera.
void cover(SimulatedCamera::Frame& frame, double part) {
  cv::Mat gray = gray_mat(frame), depth = depth_mat(frame);
  const int rows = static_cast<int>(std::lround(part * gray.rows));
  const cv::Rect below(0, gray.rows - rows, gray.cols, rows);
  cv::Mat coarse(rows / 6 + 1, gray.cols / 6 + 1, CV_8U), texture;
  cv::RNG(1).fill(coarse, cv::RNG::UNIFORM, 60, 200);
  cv::resize(coarse, texture, below.size(), 0, 0, cv::INTER_CUBIC);
  texture.copyTo(gray(below));
  depth(below).setTo(300);  // [mm]
}

std::string matrix_rows(const SE3<double>& T) {
  std::string out;
  for (int i = 0; i < 3; ++i) {
    out += format("%s%.12g, %.12g, %.12g, %.12g,\n", i == 0 ? "[" : "   ", T.R()(i, 0), T.R()(i, 1), T.R()(i, 2),
                  T.p()[i]);
  }
  return out + "   0.0, 0.0, 0.0, 1.0]\n";
}

/// IMU samples and the full state of the body at their times, in the columns of the EuRoC format.
struct InertialText {
  std::string imu, imu_in_seconds;
  std::string states =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
      "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
      "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";

  void add(const ImuSample& s) {
    const auto columns = [&](char separator) {
      std::string text;
      for (const Vec<double, 3>& x : {s.gyro, s.accel}) {
        for (int k = 0; k < 3; ++k) text += format("%c%.12g", separator, x[k]);
      }
      return text + "\n";
    };
    imu += std::to_string(s.t_ns) + columns(',');
    imu_in_seconds += seconds(s.t_ns) + columns(' ');
  }

  /// `rates`: velocity, bias of the gyroscope, bias of the accelerometer.
  void add(TimeNs t_ns, const SE3<double>& T_world_body, const std::array<Vec<double, 3>, 3>& rates) {
    const Eigen::Quaternion<double>& q = T_world_body.rotation().quaternion();
    const Vec<double, 3>& p = T_world_body.p();
    states += std::to_string(t_ns) +
              format(",%.9f,%.9f,%.9f,%.12f,%.12f,%.12f,%.12f", p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
    for (const Vec<double, 3>& x : rates) states += format(",%.9f,%.9f,%.9f", x.x(), x.y(), x.z());
    states += "\n";
  }
};

InertialText simulate_imu(const Trajectory& trajectory, ImuQuality quality, const SimulateFaults& faults,
                          std::uint64_t seed, int samples) {
  quality.noise.gyro_density *= faults.noise_factor;
  quality.noise.accel_density *= faults.noise_factor;
  SimulatedImu imu(quality, seed);
  ImuFaults fault(faults);
  const TimeNs period_ns = std::llround(1e9 / quality.noise.rate_hz);
  InertialText out;
  for (int i = 0; i < samples; ++i) {
    const SimulatedImu::Measurement r = imu.next(trajectory);
    const ImuSample exact = r.sample(t_start_ns);
    out.add(fault(exact, period_ns));
    out.add(exact.t_ns, r.motion.T_world_body, {r.motion.v_world_body, r.gyro_bias, r.accel_bias});
  }
  return out;
}

std::string noise_yaml(const ImuNoise& noise, const char* indent) {
  return format(
      "%srate_hz: %g\n%sgyroscope_noise_density: %g       # rad/s/sqrt(Hz)\n"
      "%sgyroscope_random_walk: %g         # rad/s^2/sqrt(Hz)\n"
      "%saccelerometer_noise_density: %g   # m/s^2/sqrt(Hz)\n"
      "%saccelerometer_random_walk: %g     # m/s^3/sqrt(Hz)\n",
      indent, noise.rate_hz, indent, noise.gyro_density, indent, noise.gyro_walk, indent, noise.accel_density, indent,
      noise.accel_walk);
}

/// A camera on a path through a scene, and what the IMU beside it measures.
template <class Path>
struct Recording {
  SimulateOptions options;
  Scene scene;
  Path path;
  SE3<double> T_body_camera;
  InertialText inertial;
  std::optional<ImuNoise> imu;  ///< nothing: no IMU in the recording
  TimeNs start_ns;              ///< of the first frame, t = 0 of the path
  int frames;
  std::vector<bool> kept = frames_kept(frames, options.drop, longest_drop, options.seed);

  TimeNs frame_time_ns(int frame) const { return start_ns + TimeNs(frame) * (1'000'000'000 / camera_rate_hz); }
  /// Of an image; truth and IMU samples have their own.
  TimeNs stamp_ns(int frame) const { return frame_time_ns(frame) + std::llround(1e9 * options.late_s); }
  /// As the calibration has it.
  SE3<double> stated_T_body_camera() const {
    return {T_body_camera.rotation() * options.faults.extrinsics_turn(), T_body_camera.p()};
  }

  /// Calls `use(frame)` for every frame that is there.
  template <class Use>
  void for_each_frame(Use&& use) const {
    for (int i = 0; i < frames; ++i) {
      if (kept[static_cast<std::size_t>(i)]) use(i);
    }
  }

  /// Renders every frame and hands it to `write(time stamp, frame)`.
  template <class Model, class Write>
  void film(const Imager<Model>& imager, Write&& write) const {
    CameraEffects effects;
    effects.readout_s = options.readout_s;
    SimulatedCamera sensor(Renderer(scene, imager.camera, imager.width, imager.height), T_body_camera, effects,
                           options.seed);
    Progress progress("simulate", static_cast<std::size_t>(frames));
    for_each_frame([&](int i) {
      SimulatedCamera::Frame frame =
          sensor.frame(path, i / static_cast<double>(camera_rate_hz), static_cast<std::uint64_t>(i));
      if (options.faults.bonnet > 0) cover(frame, options.faults.bonnet);
      write(stamp_ns(i), frame);
      progress.show(static_cast<std::size_t>(i + 1));
    });
  }
};

void write_tum(const Recording<Trajectory>& recording) {
  const fs::path& out = recording.options.out;
  fs::create_directories(out / "rgb");
  fs::create_directories(out / "depth");
  const auto imager = rgbd_imager.resized(recording.options.size);
  const auto& camera = imager.camera;
  recording.film(imager, [&](TimeNs stamp_ns, SimulatedCamera::Frame& frame) {
    write_image(out / "rgb" / image_name(stamp_ns), gray_mat(frame));
    write_image(out / "depth" / image_name(stamp_ns), depth_mat(frame));
  });

  write_text(out / "groundtruth_body.csv", recording.inertial.states);
  if (recording.imu) {
    write_text(out / "imu.csv", "#timestamp [s] wx wy wz ax ay az\n" + recording.inertial.imu_in_seconds);
  }
  write_text(
      out / "calibration.yaml",
      format(
          "camera:\n  model: pinhole\n  intrinsics: [%g, %g, %g, %g]        # fx fy cx cy, px\n  distortion: none\n"
          "  resolution: [%d, %d]\n  rate_hz: %d\n"
          "depth:\n  scale: %g                     # meters = value / scale; 0 = no measurement\n"
          "T_body_camera:                  # row-major 4x4, maps camera coordinates into body (= IMU) coordinates\n  ",
          camera.fx, camera.fy, camera.cx, camera.cy, imager.width, imager.height, camera_rate_hz,
          recording.options.faults.stated_depth_scale) +
          matrix_rows(recording.stated_T_body_camera()) +
          (recording.imu ? "imu:\n" + noise_yaml(*recording.imu, "  ") : ""));

  std::string truth = "# true poses of the camera\n# timestamp tx ty tz qx qy qz qw\n", gray = "# timestamp filename\n";
  std::string depth = gray;
  recording.for_each_frame([&](int i) {
    const TimeNs stamp_ns = recording.stamp_ns(i);
    const SE3<double> T =
        recording.path.at(i / static_cast<double>(camera_rate_hz)).T_world_body * recording.T_body_camera;
    const Eigen::Quaternion<double>& q = T.rotation().quaternion();
    truth += seconds(recording.frame_time_ns(i)) + format(" %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", T.p().x(),
                                                          T.p().y(), T.p().z(), q.x(), q.y(), q.z(), q.w());
    gray += seconds(stamp_ns) + " rgb/" + image_name(stamp_ns) + "\n";
    depth += seconds(stamp_ns) + " depth/" + image_name(stamp_ns) + "\n";
  });
  write_text(out / "groundtruth.txt", truth);
  write_text(out / "depth.txt", depth);
  write_text(out / "rgb.txt", gray);  // last: what makes the folder a recording
}

template <class Path>
void write_euroc(const Recording<Path>& recording, const Imager<Pinhole<double, RadTan>>& full_imager) {
  const fs::path mav = recording.options.out / "mav0", images = mav / "cam0" / "data";
  fs::create_directories(images);
  const auto imager = full_imager.resized(recording.options.size);
  const auto& camera = imager.camera;
  recording.film(imager, [&](TimeNs stamp_ns, SimulatedCamera::Frame& frame) {
    write_image(images / image_name(stamp_ns), gray_mat(frame));
  });

  const auto pose_yaml = [](const SE3<double>& T) { return "T_BS:\n  cols: 4\n  rows: 4\n  data: " + matrix_rows(T); };
  const fs::path truth = mav / "state_groundtruth_estimate0", imu = mav / "imu0";
  fs::create_directories(truth);
  write_text(truth / "sensor.yaml", "sensor_type: visual-inertial\n" + pose_yaml({}));
  write_text(truth / "data.csv", recording.inertial.states);
  if (recording.imu) {
    fs::create_directories(imu);
    write_text(imu / "sensor.yaml", "sensor_type: imu\n" + pose_yaml({}) + noise_yaml(*recording.imu, ""));
    write_text(imu / "data.csv",
               "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
               "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n" +
                   recording.inertial.imu);
  }
  const RadTan<double>& lens = camera.distortion;
  write_text(mav / "cam0" / "sensor.yaml",
             "sensor_type: camera\n" + pose_yaml(recording.stated_T_body_camera()) +
                 format("rate_hz: %d\nresolution: [%d, %d]\ncamera_model: pinhole\n"
                        "intrinsics: [%g, %g, %g, %g] #fu, fv, cu, cv\ndistortion_model: radial-tangential\n"
                        "distortion_coefficients: [%g, %g, %g, %g]\n",
                        camera_rate_hz, imager.width, imager.height, camera.fx, camera.fy, camera.cx, camera.cy,
                        lens.k1(), lens.k2(), lens.p1(), lens.p2()));
  std::string index = "#timestamp [ns],filename\n";
  recording.for_each_frame(
      [&](int i) { index += std::to_string(recording.stamp_ns(i)) + "," + image_name(recording.stamp_ns(i)) + "\n"; });
  write_text(mav / "cam0" / "data.csv", index);  // last: what makes the folder a recording
}

ImuQuality imu_quality(const std::string& name) {
  for (const ImuSet& set : imu_sets) {
    if (name == set.name) return set.quality;
  }
  throw Misuse(unknown_name("IMU", name, imu_names()));
}

void make_folder(const fs::path& out) {
  if (fs::exists(out) && !(fs::is_directory(out) && fs::is_empty(out))) {
    throw std::runtime_error(out.string() + ": exists and is not an empty folder");
  }
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw std::runtime_error(out.string() + ": cannot be made: " + error.message());
}

/// The camera of a calibration, which the layout `euroc` can state.
Imager<Pinhole<double, RadTan>> imager_of(const io::CameraCalibration& camera, const fs::path& file) {
  const auto model = io::make_camera<double>(camera);
  const auto* pinhole = std::get_if<Pinhole<double, RadTan>>(&model.model());
  if (!pinhole) throw std::runtime_error(file.string() + ": not a pinhole camera with distortion radtan");
  return {*pinhole, camera.width, camera.height};
}

Vec<double, 3> vector_in_columns(const io::RowReader& row, std::size_t i) {
  return {row.number(i), row.number(i + 1), row.number(i + 2)};
}

/// A row of the true states of the EuRoC layout.
struct TrueState {
  TimeNs t_ns;
  SE3<double> T_world_body;
  std::array<Vec<double, 3>, 3> rates;  ///< velocity, bias of the gyroscope, bias of the accelerometer
};

std::vector<TrueState> read_true_states(const fs::path& file) {
  std::vector<TrueState> out;
  for (io::RowReader row(file); row.next();) {
    row.require_size(17);
    const Eigen::Quaterniond q(row.number(4), row.number(5), row.number(6), row.number(7));
    out.push_back({row.time_in_nanoseconds(),
                   SE3<double>(SO3<double>(q), vector_in_columns(row, 1)),
                   {vector_in_columns(row, 8), vector_in_columns(row, 11), vector_in_columns(row, 14)}});
  }
  if (out.size() < 2) throw std::runtime_error(file.string() + ": fewer than two states");
  return out;
}

/// Says where the true positions jump: there the images show a motion that no IMU sample has.
void note_largest_jump(const std::vector<TrueState>& states, TimeNs first_ns) {
  constexpr double largest_m = 2e-3;  // a tenth of what a corner moves by a pixel at 5 m
  double largest_jump_m = 0, at_s = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    const TrueState &a = states[i - 1], &b = states[i];
    const Vec<double, 3> expected = 0.5e-9 * double(b.t_ns - a.t_ns) * (a.rates[0] + b.rates[0]);
    const double jump = (b.T_world_body.p() - a.T_world_body.p() - expected).norm();
    if (jump > largest_jump_m) largest_jump_m = jump, at_s = 1e-9 * double(b.t_ns - first_ns);
  }
  if (largest_jump_m > largest_m)
    std::fprintf(stderr, "plumbline: note: the true positions jump, by %.3f m at %.2f s; the images jump with them\n",
                 largest_jump_m, at_s);
}

/// Images along the path of a recorded flight, beside its real IMU samples.
int simulate_real_imu(const SimulateOptions& options) {
  constexpr double clearance = 2.5;  // [m] from the path to walls and ceiling; half of it to the floor
  const fs::path mav = options.real_imu / "mav0";
  const fs::path camera_file = options.calibration.empty() ? mav / "cam0" / "sensor.yaml" : options.calibration;
  if (!fs::exists(camera_file))
    throw std::runtime_error(camera_file.string() + ": no such file; --calibration names that of the camera");
  const io::Calibration calibration = io::read_calibration(camera_file, mav / "imu0" / "sensor.yaml");
  if (!calibration.T_body_camera) throw std::runtime_error(camera_file.string() + ": states no pose of the camera");
  const auto imager = imager_of(calibration.camera, camera_file);

  std::vector<TrueState> states = read_true_states(mav / "state_groundtruth_estimate0" / "data.csv");
  const TimeNs first_ns = states.front().t_ns, begin_ns = first_ns + TimeNs(std::llround(1e9 * options.start_s));
  const TimeNs last_ns = std::min(states.back().t_ns, begin_ns + TimeNs(std::llround(1e9 * options.duration_s)));
  const int frames = static_cast<int>(double(last_ns - begin_ns) * 1e-9 * camera_rate_hz);
  if (frames < 1) throw Misuse(format("--start %g: the true states end before", options.start_s));
  const auto is_used = [&](TimeNs t_ns) { return t_ns >= begin_ns && t_ns <= last_ns; };
  std::erase_if(states, [&](const TrueState& state) { return !is_used(state.t_ns); });
  if (states.size() < 2) throw Misuse(format("--duration %g: fewer than two true states", options.duration_s));
  note_largest_jump(states, first_ns);

  std::vector<RecordedPath::Sample> samples;
  samples.reserve(states.size());
  for (const TrueState& state : states) samples.push_back({state.t_ns, state.T_world_body});
  RecordedPath path(std::move(samples), begin_ns);
  const RecordedPath::Bounds bounds = path.bounds();
  const Vec<double, 3> middle = 0.5 * (bounds.min + bounds.max), half = 0.5 * (bounds.max - bounds.min);
  const Vec<double, 3> offset(-middle.x(), -middle.y(), 0.5 * clearance - bounds.min.z());
  path.shift(offset);

  InertialText inertial;
  for (const TrueState& state : states) {
    const SE3<double>& T = state.T_world_body;
    inertial.add(state.t_ns, SE3<double>(T.rotation(), T.p() + offset), state.rates);
  }
  ImuFaults fault(options.faults);
  const double rate_hz = calibration.imu && calibration.imu->rate_hz > 0 ? calibration.imu->rate_hz : imu_rate_hz;
  const TimeNs period_ns = std::llround(1e9 / rate_hz);
  for (io::RowReader row(mav / "imu0" / "data.csv"); row.next();) {
    row.require_size(7);
    const TimeNs t_ns = row.time_in_nanoseconds();
    const ImuSample sample{t_ns, vector_in_columns(row, 1), vector_in_columns(row, 4)};
    if (is_used(t_ns)) inertial.add(fault(sample, period_ns));
  }
  make_folder(options.out);
  const Scene hall =
      make_hall(half.x() + clearance, half.y() + clearance, 2 * half.z() + 1.5 * clearance, options.seed);
  write_euroc(Recording<RecordedPath>{options, hall, path, *calibration.T_body_camera, inertial, calibration.imu,
                                      begin_ns, frames},
              imager);
  return 0;
}

}  // namespace

std::vector<std::string> scene_names() { return {testing::scene_names.begin(), testing::scene_names.end()}; }

std::vector<std::string> imu_names() {
  std::vector<std::string> names;
  names.reserve(imu_sets.size());
  for (const ImuSet& set : imu_sets) names.emplace_back(set.name);
  return names;
}

std::vector<std::string> layout_names() { return {"tum", "euroc"}; }

int run_simulate(const SimulateOptions& options) {
  if (!options.real_imu.empty()) return simulate_real_imu(options);
  const std::optional<Scene> scene = make_scene(options.scene, options.seed);
  std::optional<Trajectory> trajectory = Trajectory::for_scene(options.scene, options.seed);
  if (!scene || !trajectory) throw Misuse(unknown_name("scene", options.scene, ::scene_names()));
  if (options.faults.has_depth_fault() && options.layout != "tum")
    throw Misuse("--stated-depth-scale needs --layout tum");
  if (options.layout != "tum" && options.layout != "euroc")
    throw Misuse(unknown_name("layout", options.layout, layout_names()));
  if (options.stop_s.size() == 2 && !(options.stop_s[0] < options.stop_s[1]))
    throw Misuse(format("--stop %g %g: ends before it begins", options.stop_s[0], options.stop_s[1]));
  if (options.stop_s.size() == 2) trajectory->stop(options.stop_s[0], options.stop_s[1]);
  const ImuQuality imu = imu_quality(options.imu);
  constexpr double longest_s = 3600;
  double duration_s = options.laps > 0 ? trajectory->end_of_lap_s(options.laps) : options.duration_s;
  if (options.laps > 0 && options.stop_s.size() == 2) duration_s += options.stop_s[1] - options.stop_s[0];
  if (!(duration_s >= 1.0 / camera_rate_hz && duration_s <= longest_s)) {
    throw Misuse(format("duration %g s: must be between one frame and one hour", duration_s));
  }
  make_folder(options.out);
  const int frames = static_cast<int>(std::lround(duration_s * camera_rate_hz));
  const Recording<Trajectory> recording{
      options,
      *scene,
      *trajectory,
      simulated_T_body_camera(),
      simulate_imu(*trajectory, imu, options.faults, options.seed, frames * imu_per_frame + 1),
      options.imu == "none" ? std::nullopt : std::optional(imu.noise),
      t_start_ns,
      frames};
  options.layout == "tum" ? write_tum(recording) : write_euroc(recording, mono_imager);
  return 0;
}
