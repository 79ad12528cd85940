#include "runner.hpp"

#include <algorithm>
#include <iterator>

// Those that were not compiled in (PLUMBLINE_CONFIGURATIONS) are null.
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_points_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_lines_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_points_lines_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_imu_points_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_imu_lines_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_rgbd_imu_points_lines_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_mono_imu_points_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_mono_imu_lines_window(const plumbline::io::Calibration& calibration);
[[gnu::weak]] std::unique_ptr<Runner> make_mono_imu_points_lines_window(const plumbline::io::Calibration& calibration);

std::span<const Configuration> configurations() {
  constexpr Needs rgbd{.depth = true, .imu = false}, rgbd_imu{.depth = true, .imu = true},
      mono_imu{.depth = false, .imu = true};
  const Configuration all[] = {
      {"rgbd/points/window", rgbd, make_rgbd_points_window},
      {"rgbd/lines/window", rgbd, make_rgbd_lines_window},
      {"rgbd/points+lines/window", rgbd, make_rgbd_points_lines_window},
      {"rgbd-imu/points/window", rgbd_imu, make_rgbd_imu_points_window},
      {"rgbd-imu/lines/window", rgbd_imu, make_rgbd_imu_lines_window},
      {"rgbd-imu/points+lines/window", rgbd_imu, make_rgbd_imu_points_lines_window},
      {"mono-imu/points/window", mono_imu, make_mono_imu_points_window},
      {"mono-imu/lines/window", mono_imu, make_mono_imu_lines_window},
      {"mono-imu/points+lines/window", mono_imu, make_mono_imu_points_lines_window},
      {"rgbd-inertial-vio", rgbd_imu, make_rgbd_imu_points_lines_window},  // published, see systems/
  };
  static const std::vector<Configuration> compiled = [&] {
    std::vector<Configuration> out;
    std::copy_if(std::begin(all), std::end(all), std::back_inserter(out),
                 [](const Configuration& c) { return c.make; });
    return out;
  }();
  return compiled;
}
