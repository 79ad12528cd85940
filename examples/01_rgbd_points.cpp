// Visual odometry of a recording with depth. Writes every pose as a line "time x y z qx qy qz qw" (TUM format).
//
//   example_01_rgbd_points <directory of the recording>
#include <cstdio>
#include <exception>
#include <memory>

#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/plumbline.hpp"

namespace pl = plumbline;

// The sensors, the features and the solver, all in the type. Sizes are part of it: images of up to a megapixel, up to
// 400 points, a window of 10 keyframes.
using Sensors = pl::Rig<pl::Rgbd<pl::AnyCamera<double>, 1280 * 800>>;
using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<400>>, pl::SlidingWindow<10>>;

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s <directory of a recording with depth>\n", argv[0]), 1;
  const auto recording = pl::io::Recording::open(argv[1]);
  if (!recording.has_depth()) return std::fprintf(stderr, "%s: no depth images\n", argv[1]), 1;
  const pl::io::Calibration& calibration = recording.calibration();

  Sensors sensors{};
  sensors.vision.camera = pl::io::make_camera<double>(calibration.camera);
  sensors.vision.width = calibration.camera.width;
  sensors.vision.height = calibration.camera.height;
  sensors.vision.depth.units_per_meter = calibration.depth_scale;
  const auto vo = std::make_unique<Vo>(sensors);  // the only memory it will ever use

  for (const pl::io::FrameSample& sample : recording.frames()) {
    const cv::Mat gray = pl::opencv::read_gray(sample.image);
    const cv::Mat depth = sample.depth ? pl::opencv::read_depth(*sample.depth) : cv::Mat();
    const auto estimate =
        vo->add_frame({sample.t_ns, pl::opencv::view<std::uint8_t>(gray), pl::opencv::view<std::uint16_t>(depth)});
    if (!estimate || estimate->health.state != pl::HealthState::tracking) continue;
    const auto& p = estimate->T_world_body.p();
    const auto q = estimate->T_world_body.rotation().quaternion().coeffs();
    std::printf("%.9f %.6f %.6f %.6f %.7f %.7f %.7f %.7f\n", 1e-9 * double(estimate->t_ns), p.x(), p.y(), p.z(), q.x(),
                q.y(), q.z(), q.w());
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
