#include "runner.hpp"

std::unique_ptr<Runner> make_rgbd_points_window(const plumbline::io::Calibration& calibration);

std::span<const Configuration> configurations() {
  static constexpr Configuration all[] = {
      {.name = "rgbd/points/window", .needs_depth = true, .needs_imu = false, .make = make_rgbd_points_window},
  };
  return all;
}
