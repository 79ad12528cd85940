#include "estimator.hpp"

#include <cmath>
#include <vector>

#include "calibrated_sensors.hpp"
#include "plumbline/io/calibration.hpp"

namespace pl = plumbline;
namespace py = pybind11;

namespace {

pl::io::Calibration read(const std::filesystem::path& file, const PythonEstimator::Options& options) {
  pl::io::Calibration out = options.imu_calibration ? pl::io::read_calibration(file, *options.imu_calibration)
                                                    : pl::io::read_calibration(file);
  if (options.depth_scale > 0) out.depth_scale = options.depth_scale;
  return out;
}

void require_size(const cv::Mat& image, const std::string& name, const pl::io::CameraCalibration& camera) {
  const auto text = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (image.cols != camera.width || image.rows != camera.height)
    throw Refused(std::string(name_of(pl::Error::wrong_image_size)) + ": " + name + " is " +
                  text(image.cols, image.rows) + ", the calibration has " + text(camera.width, camera.height));
}

}  // namespace

PythonEstimator::PythonEstimator(const std::string& config, const std::filesystem::path& calibration,
                                 const Options& options)
    : configuration_(configuration_named(config)), calibration_(read(calibration, options)) {
  require_calibrated(configuration_, calibration_, calibration);
  runner_ = configuration_.make(calibration_, options.with_map);
}

void PythonEstimator::add_imu(const py::object& t_ns, const py::object& gyro, const py::object& accel) {
  if (!configuration_.needs.imu) throw Refused(std::string(configuration_.name) + " is one without an IMU");
  const py::array_t<std::int64_t> times = times_of(t_ns);
  const py::ssize_t n = times.size();
  const py::array_t<double> rates = rows_of(gyro, "gyro", n, 3), forces = rows_of(accel, "accel", n, 3);
  const std::int64_t* t = times.data();
  const double *w = rates.data(), *a = forces.data();
  py::ssize_t refused = 0, first = 0;
  pl::Error why{};
  locked([&] {
    for (py::ssize_t i = 0; i < n; ++i, w += 3, a += 3) {
      const std::optional<pl::Error> error = runner_->add_imu({t[i], {w[0], w[1], w[2]}, {a[0], a[1], a[2]}});
      if (error && ++refused == 1) {
        first = i;
        why = *error;
      }
    }
  });
  if (refused == 0) return;
  std::string text = std::string(name_of(why)) + ": the IMU sample at " + std::to_string(t[first]) + " ns";
  if (refused > 1) text += ", the first of " + std::to_string(refused) + " that are not used";
  throw Refused(text);
}

FrameOutput PythonEstimator::add_frame(pl::TimeNs t_ns, const py::array& gray, const std::optional<py::array>& depth) {
  const cv::Mat gray_view = image_view<std::uint8_t>(gray, "gray");
  const cv::Mat depth_view = depth ? image_view<std::uint16_t>(*depth, "depth") : cv::Mat();
  if (depth && !configuration_.needs.depth) throw Refused(std::string(configuration_.name) + " is one without depth");
  require_size(gray_view, "gray", calibration_.camera);
  if (depth) require_size(depth_view, "depth", calibration_.camera);
  const FrameOutput output = locked([&] {
    const FrameOutput out =
        runner_->add_frame(frame_time(configuration_.needs, calibration_, t_ns), gray_view, depth_view);
    if (!out.refused) latest_ = out;
    return out;
  });
  if (output.refused)
    throw Refused(std::string(name_of(*output.refused)) + ": the frame at " + std::to_string(t_ns) + " ns");
  return output;
}

std::optional<FrameOutput> PythonEstimator::state() const {
  return locked([&] { return latest_; });
}
pl::HealthState PythonEstimator::health() const {
  return locked([&] { return latest_ ? latest_->health() : pl::HealthState::initializing; });
}
double PythonEstimator::time_offset_s() const {
  const double known = configuration_.needs.imu ? calibration_.camera_time_offset_s : 0;
  return known + locked([&] { return runner_->time_offset_s(); });
}

py::array_t<double> PythonEstimator::landmarks() const {
  const std::vector<pl::Vec<double, 3>> points = locked([&] { return runner_->landmarks(); });
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  for (py::ssize_t i = 0; i < out.shape(0); ++i)
    for (int k = 0; k < 3; ++k) out.mutable_at(i, k) = points[static_cast<std::size_t>(i)][k];
  return out;
}
