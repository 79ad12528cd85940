#include "recorded.h"

#include <algorithm>
#include <filesystem>
#include <variant>
#include <vector>

#include "plumbline/io/recording.hpp"

namespace io = plumbline::io;

namespace {

struct Item {
  plumbline::ImuSample sample;
  plumbline::TimeNs frame_ns = 0;
  cv::Mat gray;
};
std::vector<Item> items;
io::Trajectory truth;

}  // namespace

int recorded_open(const char* folder, double seconds, recorded* out) {
  if (!std::filesystem::exists(folder)) return 0;
  io::Recording recording = io::Recording::open(folder, {.calibration = {}, .start_s = 0, .duration_s = seconds});
  truth = recording.read_groundtruth(true).value();
  io::Recording::Sample sample;
  while (recording.next(sample)) {
    Item item;
    if (const auto* imu = std::get_if<plumbline::ImuSample>(&sample)) {
      item.sample = *imu;
    } else {
      const auto& frame = std::get<io::FrameSample>(sample);
      item.frame_ns = frame.t_ns;
      item.gray = io::read_gray(frame);
    }
    items.push_back(item);
  }
  const io::Calibration& calibration = recording.calibration();
  out->config = PLUMBLINE_CONFIG_INIT;
  out->config.camera_model = PLUMBLINE_RADTAN;
  out->config.width = calibration.camera.width;
  out->config.height = calibration.camera.height;
  std::copy_n(calibration.camera.intrinsics.begin(), 4, out->config.intrinsics);
  std::copy(calibration.camera.distortion_coefficients.begin(), calibration.camera.distortion_coefficients.end(),
            out->config.parameters);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out->config.T_body_camera[4 * i + j] = calibration.T_body_camera->R()(i, j);
    out->config.T_body_camera[4 * i + 3] = calibration.T_body_camera->p()[i];
  }
  out->config.T_body_camera[15] = 1;
  out->config.gyro_density = calibration.imu->gyro_density;
  out->config.accel_density = calibration.imu->accel_density;
  out->config.gyro_walk = calibration.imu->gyro_walk;
  out->config.accel_walk = calibration.imu->accel_walk;
  out->config.imu_rate_hz = calibration.imu->rate_hz;
  out->count = static_cast<int>(items.size());
  return 1;
}

void recorded_item(int i, plumbline_imu_sample* sample, plumbline_frame* frame) {
  const Item& item = items[static_cast<std::size_t>(i)];
  *sample = PLUMBLINE_IMU_SAMPLE_INIT;
  *frame = PLUMBLINE_FRAME_INIT;
  if (item.frame_ns == 0) {
    sample->t_ns = item.sample.t_ns;
    std::copy_n(item.sample.gyro.data(), 3, sample->gyro);
    std::copy_n(item.sample.accel.data(), 3, sample->accel);
    return;
  }
  frame->t_ns = item.frame_ns;
  frame->width = item.gray.cols;
  frame->height = item.gray.rows;
  frame->gray = item.gray.data;
  frame->gray_stride = item.gray.step;
}

double recorded_distance(int64_t from_ns, int64_t to_ns) {
  const auto at = [](int64_t t_ns) {
    return std::find_if(truth.begin(), truth.end() - 1, [&](const auto& pose) { return pose.t_ns >= t_ns; })
        ->T_world_body.p();
  };
  return (at(to_ns) - at(from_ns)).norm();
}
