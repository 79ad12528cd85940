#include "calibration_command.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "format.hpp"
#include "misuse.hpp"
#include "nearest.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/calibration_writer.hpp"
#include "plumbline/io/imu_calibration_search.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/printable.hpp"
#include "recording_options.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

using Lines = std::vector<std::string>;

std::string name_of(const io::CameraCalibration& camera) {
  const std::string model = camera.model == "double_sphere" ? "double sphere"
                            : camera.model == "omni"        ? "omnidirectional (Mei)"
                            : camera.model == "eucm"        ? "extended unified (EUCM)"
                                                            : "pinhole";
  const std::string& d = camera.distortion;
  return model + (d == "radtan"        ? " with radial-tangential distortion"
                  : d == "rational"    ? " with rational distortion"
                  : d == "equidistant" ? " with equidistant distortion (Kannala-Brandt)"
                  : d == "fov"         ? " with FOV distortion"
                                       : " without distortion");
}

/// "k1 -0.28, k2 0.07, ..."
std::string named(const Lines& names, const std::vector<double>& values, std::size_t first) {
  std::string out;
  for (std::size_t i = first; i < values.size() && i - first < names.size(); ++i)
    out += (out.empty() ? "" : ", ") + names[i - first] + format(" %.8g", values[i]);
  return out;
}

/// Between the bearings of the middles of two opposite borders [deg]; NaN where one has none.
double angle_across(const pl::AnyCamera<double>& camera, const pl::Vec<double, 2>& a, const pl::Vec<double, 2>& b) {
  const auto first = camera.unproject(a), last = camera.unproject(b);
  if (!first.valid || !last.valid) return std::numeric_limits<double>::quiet_NaN();
  const auto axis = camera.unproject((a + b) / 2);
  const auto angle = [](const pl::Vec<double, 3>& p, const pl::Vec<double, 3>& q) {
    return std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::numbers::pi;
  };
  return axis.valid ? angle(first.bearing, axis.bearing) + angle(axis.bearing, last.bearing)
                    : std::numeric_limits<double>::quiet_NaN();
}

void add_camera(const io::Calibration& calibration, Lines& out) {
  const io::CameraCalibration& camera = calibration.camera;
  const std::vector<double>& v = camera.intrinsics;
  out.push_back("camera: " + name_of(camera));
  out.push_back(format("  images               %d x %d px", camera.width, camera.height) +
                (camera.rate_hz > 0 ? format(", %.4g Hz", camera.rate_hz) : ""));
  out.push_back(format("  focal lengths        %.8g, %.8g px (x, y)", v[0], v[1]));
  out.push_back(format("  principal point      %.8g, %.8g px (x, y), the center of the image is %.1f, %.1f", v[2], v[3],
                       (camera.width - 1) / 2.0, (camera.height - 1) / 2.0));
  const Lines shape = camera.model == "eucm" ? Lines{"alpha", "beta"} : Lines{"xi", "alpha"};
  if (v.size() > 4) out.push_back("  shape                " + named(shape, v, 4));
  const std::string& d = camera.distortion;
  const Lines names = d == "fov"           ? Lines{"w"}
                      : d == "equidistant" ? Lines{"k1", "k2", "k3", "k4"}
                                           : Lines{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  if (d != "none") out.push_back("  distortion           " + named(names, camera.distortion_coefficients, 0));
  const pl::AnyCamera<double> model = io::make_camera<double>(camera);
  const double w = camera.width - 1, h = camera.height - 1;
  const double across = angle_across(model, {0, v[3]}, {w, v[3]}), down = angle_across(model, {v[2], 0}, {v[2], h});
  if (std::isfinite(across) && std::isfinite(down))
    out.push_back(format("  field of view        %.1f degrees across, %.1f down", across, down));
  else
    out.push_back("  field of view        does not reach the borders of the image: pixels outside of it are not used");
  out.push_back("  shutter              " +
                (!camera.readout_s ? std::string("not stated, taken to be global")
                 : *camera.readout_s > 0
                     ? format("rolling, %.4g ms from the first to the last row", *camera.readout_s * 1e3)
                     : std::string("global")));
  if (calibration.mask) out.push_back("  mask                 " + calibration.mask->string());
  if (calibration.depth_scale > 0)
    out.push_back(format("  depth                a value of %.6g is 1 m", calibration.depth_scale));
}

/// Its numbers, and the axis that it is near.
std::string direction(const pl::Vec<double, 3>& d) {
  const std::array<const char*, 3> axes{"x", "y", "z"};
  std::string out = format("% .4f % .4f % .4f", d.x(), d.y(), d.z());
  for (int i = 0; i < 3; ++i)
    if (std::abs(d[i]) > 0.98) out += std::string("  (about ") + (d[i] > 0 ? "+" : "-") + axes[std::size_t(i)] + ")";
  return out;
}

void add_pose(const io::Calibration& calibration, Lines& out) {
  if (!calibration.T_body_camera) {
    out.emplace_back("camera and IMU: no transform between them is stated");
    return;
  }
  const pl::SE3<double>& T = *calibration.T_body_camera;
  const pl::Vec<double, 3> p = T.p(), back = T.inverse().p();
  out.emplace_back("camera and IMU: the frame of the body is that of the IMU");
  out.push_back(format("  position of the camera in the IMU frame [m]   % .5f % .5f % .5f", p.x(), p.y(), p.z()));
  out.push_back(
      format("  position of the IMU in the camera frame [m]   % .5f % .5f % .5f", back.x(), back.y(), back.z()));
  out.push_back("  the camera looks along, in the IMU frame      " + direction(T.R().col(2)));
  out.push_back("  the images' right, in the IMU frame           " + direction(T.R().col(0)));
  out.push_back("  the images' down, in the IMU frame            " + direction(T.R().col(1)));
}

void add_time(const io::Calibration& calibration, Lines& out) {
  const double offset = calibration.camera_time_offset_s;
  out.push_back(format("time offset: %.6g s, IMU time = time stamp of the image + offset", offset));
  if (offset != 0)
    out.push_back(format("  an image is stamped %.3g ms %s the time at which the IMU measured its motion",
                         std::abs(offset) * 1e3, offset > 0 ? "before" : "after"));
}

/// What sensors of robots have: from a good MEMS sensor (ADIS16448, BMI088) to that of a phone, an order of magnitude
/// wider.
struct Usual {
  const char* name;
  double value, low, high;
  const char* unit;
};

void add_noise(const io::Calibration& calibration, Lines& out) {
  if (!calibration.imu) {
    out.emplace_back("noise of the IMU: not stated (imu.yaml by --imu-calibration)");
    return;
  }
  const pl::ImuNoise& noise = *calibration.imu;
  out.push_back(format("noise of the IMU, continuous in time, at %.6g Hz", noise.rate_hz));
  const double root_rate = std::sqrt(noise.rate_hz);
  for (const Usual& each : {Usual{"gyroscope noise density", noise.gyro_density, 1e-5, 2e-3, "rad/s/sqrt(Hz)"},
                            {"gyroscope random walk", noise.gyro_walk, 1e-7, 1e-3, "rad/s^2/sqrt(Hz)"},
                            {"accelerometer noise density", noise.accel_density, 1e-4, 3e-2, "m/s^2/sqrt(Hz)"},
                            {"accelerometer random walk", noise.accel_walk, 1e-6, 2e-2, "m/s^3/sqrt(Hz)"}}) {
    const bool is_density = std::string_view(each.name).ends_with("density");
    const std::string unit = each.unit;
    std::string text = format("  %-28s %-9.4g %-18s", each.name, each.value, each.unit);
    if (each.value > each.high)
      text += format(" large: usual are %g to %g", each.low, each.high) +
              (is_density ? "; the noise of one sample (divide by the root of the rate), or inflated?" : "; inflated?");
    else if (each.value < each.low)
      text += format(" small: usual are %g to %g; another unit?", each.low, each.high);
    else
      text += " plausible";
    if (is_density)
      text += format("; one sample has a sigma of %.3g %s", each.value * root_rate,
                     unit.substr(0, unit.find("/sqrt")).c_str());
    out.push_back(text);
  }
  const pl::ImuBufferOptions& limits = calibration.imu_limits;
  out.push_back(format("  full scales                  %.4g rad/s, %.4g m/s^2", double(limits.gyro_full_scale),
                       double(limits.accel_full_scale)));
}

}  // namespace

std::vector<std::string> describe(const io::Calibration& calibration) {
  Lines out;
  add_camera(calibration, out);
  add_pose(calibration, out);
  add_time(calibration, out);
  add_noise(calibration, out);
  return out;
}

int run_calibration(const CalibrationOptions& options) {
  const std::vector<std::string> formats(io::written_formats.begin(), io::written_formats.end());
  if (!options.to.empty() && std::find(formats.begin(), formats.end(), options.to) == formats.end())
    throw Misuse(unknown_name("format", options.to, formats));
  io::Calibration calibration = io::read_calibration(options.file);
  std::optional<std::filesystem::path> imu = options.imu_calibration;
  if (!imu && !calibration.imu) {
    const auto beside = io::imu_calibrations_beside(options.file);
    if (beside.size() == 1) imu = beside.front();
    if (imu) calibration.notes.push_back(imu->string() + ": the noise of the IMU is taken from this file");
  }
  if (imu) io::detail::read_imu(io::YamlMap(*imu), calibration);
  print_notes(calibration.notes);

  const std::string comment = options.to.empty() ? "" : "# ";
  std::string text = comment + options.file.filename().string() + "\n";
  for (const std::string& line : describe(calibration)) text += comment + line + "\n";
  if (!options.to.empty()) {
    io::WrittenCalibration written;
    try {
      written = io::write_calibration(calibration, options.to);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(options.file.string() + ": " + error.what());
    }
    for (const std::string& lost : written.lost) print_note("not in the format " + options.to + ": " + lost);
    text += written.text;
  }
  std::fputs(text.c_str(), stdout);
  return 0;
}
