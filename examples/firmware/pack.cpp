// Writes a recording of a pinhole camera and an IMU as one block of memory (recording.hpp).
//
//   firmware_pack <folder of the recording> <output> [begin [s] [length [s]]]
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <vector>

#include "plumbline/io/output_file.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "recording.hpp"

namespace pl = plumbline;

int main(int argc, char** argv) try {
  if (argc < 3) return std::fprintf(stderr, "usage: %s <recording> <output> [begin [length]]\n", argv[0]), 1;
  pl::io::Recording::Options options;
  if (argc > 3) options.start_s = std::atof(argv[3]);
  if (argc > 4) options.duration_s = std::atof(argv[4]);
  const auto in = pl::io::Recording::open(argv[1], options);
  const pl::io::Calibration& calibration = in.calibration();
  const pl::io::CameraCalibration& camera = calibration.camera;
  if (!in.has_imu()) throw std::runtime_error(std::string(argv[1]) + ": no IMU");
  if (camera.model != "pinhole" || camera.distortion != "none")
    throw std::runtime_error(std::string(argv[1]) + ": the camera is no pinhole without distortion");

  RecordingHeader header;
  header.width = camera.width;
  header.height = camera.height;
  header.frames = int(in.frame_count());
  header.fx = camera.intrinsics[0];
  header.fy = camera.intrinsics[1];
  header.cx = camera.intrinsics[2];
  header.cy = camera.intrinsics[3];
  for (int i = 0; i < 4; ++i) header.q_body_cam[i] = calibration.T_body_camera->rotation().quaternion().coeffs()[i];
  for (int i = 0; i < 3; ++i) header.p_body_cam[i] = calibration.T_body_camera->p()[i];
  header.rate_hz = calibration.imu->rate_hz;
  header.gyro_density = calibration.imu->gyro_density;
  header.accel_density = calibration.imu->accel_density;
  header.gyro_walk = calibration.imu->gyro_walk;
  header.accel_walk = calibration.imu->accel_walk;
  // The last frames are left out whose IMU samples are not in the recording.
  std::vector<pl::TimeNs> times;
  for (const auto& frame : in.frames())
    if (frame.t_ns + 20'000'000 <= in.imu().back().t_ns) times.push_back(frame.t_ns);
  header.frames = int(times.size());
  header.samples = int(in.imu().size());

  pl::io::OutputFile out(argv[2]);
  const auto write = [&](const void* data, std::size_t size) {
    out.stream().write(static_cast<const char*>(data), std::streamsize(size));
  };
  write(&header, sizeof(header));
  write(in.imu().data(), in.imu().size() * sizeof(pl::ImuSample));
  write(times.data(), times.size() * sizeof(pl::TimeNs));
  for (std::size_t i = 0; i < times.size(); ++i) {
    const cv::Mat image = pl::opencv::read_gray(in.frames()[i].image);
    for (int y = 0; y < image.rows; ++y) write(image.ptr(y), std::size_t(image.cols));
  }
  out.commit();
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
