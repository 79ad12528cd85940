#include "runner.hpp"

std::unique_ptr<Runner> make_rgbd_points_window(const plumbline::io::Calibration& calibration);
std::unique_ptr<Runner> make_rgbd_imu_points_window(const plumbline::io::Calibration& calibration);
std::unique_ptr<Runner> make_mono_imu_points_window(const plumbline::io::Calibration& calibration);

std::span<const Configuration> configurations() {
  static constexpr Configuration all[] = {
      {.name = "rgbd/points/window", .needs_depth = true, .needs_imu = false, .make = make_rgbd_points_window},
      {.name = "rgbd-imu/points/window", .needs_depth = true, .needs_imu = true, .make = make_rgbd_imu_points_window},
      {.name = "mono-imu/points/window", .needs_depth = false, .needs_imu = true, .make = make_mono_imu_points_window},
  };
  return all;
}
