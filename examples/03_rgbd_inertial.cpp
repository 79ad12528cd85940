// RGB-D-inertial odometry with points and lines of a recording with depth and IMU: a published system by its name.
// Writes every pose of the body as a line "time x y z qx qy qz qw" (TUM format), and what keeps it from starting.
//
//   example_03_rgbd_inertial <directory of the recording>
#include <cstdio>
#include <exception>
#include <memory>
#include <variant>

#include "plumbline/camera/any_camera.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/systems/rgbd_inertial_vio.hpp"

namespace pl = plumbline;
using Vio = pl::RgbdInertialVio<pl::AnyCamera<double>, 1280 * 800>;

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s <directory of a recording with depth and IMU>\n", argv[0]), 1;
  auto recording = pl::io::Recording::open(argv[1]);
  if (!recording.has_depth() || !recording.has_imu()) return std::fprintf(stderr, "%s: no depth or IMU\n", argv[1]), 1;
  const pl::io::Calibration& calibration = recording.calibration();

  pl::Rig<pl::Rgbd<pl::AnyCamera<double>, 1280 * 800>, pl::Imu> sensors{};
  sensors.vision.camera = pl::io::make_camera<double>(calibration.camera);
  sensors.vision.width = calibration.camera.width;
  sensors.vision.height = calibration.camera.height;
  sensors.vision.depth.units_per_meter = calibration.depth_scale;
  sensors.imu.T_body_cam = *calibration.T_body_camera;
  sensors.imu.noise = *calibration.imu;
  sensors.imu.limits = calibration.imu_limits;
  const auto vio = std::make_unique<Vio>(sensors);  // the only memory it will ever use

  for (pl::io::Recording::Sample sample; recording.next(sample);) {  // IMU samples and frames in order of time
    if (const auto* imu = std::get_if<pl::ImuSample>(&sample)) {
      (void)vio->add_imu(*imu);  // an error is a rejected sample; the estimator counts them
      continue;
    }
    const auto& frame = std::get<pl::io::FrameSample>(sample);
    const cv::Mat gray = pl::opencv::read_gray(frame.image);
    const cv::Mat depth = frame.depth ? pl::opencv::read_depth(*frame.depth) : cv::Mat();
    const auto estimate =
        vio->add_frame({frame.t_ns, pl::opencv::view<std::uint8_t>(gray), pl::opencv::view<std::uint16_t>(depth)});
    if (!estimate || estimate->health.state == pl::HealthState::initializing) continue;
    const auto& p = estimate->T_world_body.p();
    const auto q = estimate->T_world_body.rotation().quaternion().coeffs();
    std::printf("%.9f %.6f %.6f %.6f %.7f %.7f %.7f %.7f\n", 1e-9 * double(estimate->t_ns), p.x(), p.y(), p.z(), q.x(),
                q.y(), q.z(), q.w());
  }
  if (vio->init_report().stage != pl::InitStage::done)
    return std::fprintf(stderr, "not started: %s\n", name_of(vio->init_report().stage)), 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
