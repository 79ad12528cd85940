#include "plumbline/feature/points.hpp"
#include "window.hpp"

std::unique_ptr<Runner> make_rgbd_points_window(const pl::io::Calibration& calibration) {
  return make_window<pl::Rig<RgbdCamera>, pl::Points<400>>(calibration);
}
